// SPDX-License-Identifier: MIT
#include "python_hooks.h"

#include <exception>
#include <mutex>

#include <opencv2/core/utils/logger.hpp>

#include "turnscale/base/escaped_text.h"

namespace py = pybind11;

namespace turnscale {
namespace {

// Names of files may not be valid UTF-8.
void Raise(const Failure& failure) {
  const std::string line = Printable(failure.message);
  PyObject* type = failure.exit_code == 2 ? PyExc_ValueError : PyExc_RuntimeError;
  PyObject* text = PyUnicode_DecodeUTF8(line.data(), static_cast<Py_ssize_t>(line.size()), "surrogateescape");
  if (text == nullptr) return;
  PyErr_SetObject(type, text);
  Py_DECREF(text);
}

// Of all threads' QuietLibraries.
std::mutex quiet_mutex;
int quiet_users = 0;
cv::utils::logging::LogLevel usual_level = cv::utils::logging::LOG_LEVEL_WARNING;

}  // namespace

QuietLibraries::QuietLibraries() {
  const std::lock_guard lock(quiet_mutex);
  if (quiet_users++ == 0) usual_level = cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
}

QuietLibraries::~QuietLibraries() {
  const std::lock_guard lock(quiet_mutex);
  if (--quiet_users == 0) cv::utils::logging::setLogLevel(usual_level);
}

void PythonHooks::Join(CommandHooks& hooks) {
  hooks.interrupted = [this] { return Interrupted(); };
  hooks.warn = [this](const std::string& warning) { Warn(warning); };
  hooks.print_warnings = false;
}

void PythonHooks::Raise() {
  if (!raised_) return;
  const py::error_already_set raised = *raised_;
  raised_.reset();
  throw raised;
}

bool PythonHooks::Interrupted() {
  if (raised_) return true;
  const py::gil_scoped_acquire lock;
  if (PyErr_CheckSignals() != 0) raised_.emplace();
  return raised_.has_value();
}

void PythonHooks::Warn(const std::string& warning) {
  constexpr int kCallerOfTheCaller = 2;
  const py::gil_scoped_acquire lock;
  if (raised_) return;
  const std::string line = Printable(warning);
  PyObject* text = PyUnicode_DecodeUTF8(line.data(), static_cast<Py_ssize_t>(line.size()), "replace");
  const std::string shown = text == nullptr ? line : py::reinterpret_steal<py::str>(text).cast<std::string>();
  PyErr_Clear();
  if (PyErr_WarnEx(PyExc_UserWarning, shown.c_str(), kCallerOfTheCaller) != 0) raised_.emplace();
}

void TranslateErrors() {
  py::register_local_exception_translator([](std::exception_ptr thrown) {
    try {
      std::rethrow_exception(thrown);
    } catch (const FailedCommand& failed) {
      Raise(failed.failure);
    } catch (const py::error_already_set&) {
      throw;
    } catch (const py::builtin_exception&) {
      throw;
    } catch (...) {
      Raise(FailureOf(std::current_exception()));
    }
  });
}

}  // namespace turnscale
