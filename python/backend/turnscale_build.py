# SPDX-License-Identifier: MIT
"""Builds the wheel of turnscale with CMake: a PEP 517 backend that needs nothing but the standard library.

The build folder is build/python, so that a second call compiles only what has changed. A setting cmake.define.NAME gives
CMake another option: pip install . --config-settings cmake.define.TURNSCALE_NATIVE=ON
"""
import base64
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import tomllib
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/python"
# Of files in the wheel, so that the same build gives the same bytes.
EPOCH = (1980, 1, 1, 0, 0, 0)


def project():
    """The project table of pyproject.toml, with the version of CMakeLists.txt."""
    table = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    table["version"] = re.search(r"^project\(turnscale VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.M)[1]
    return table


def metadata_text(table):
    lines = ["Metadata-Version: 2.1", f"Name: {table['name']}", f"Version: {table['version']}",
             f"Summary: {table['description']}", f"License: {table['license']['text']}",
             f"Requires-Python: {table['requires-python']}"]
    lines += [f"Requires-Dist: {needed}" for needed in table["dependencies"]]
    lines += ["Description-Content-Type: text/markdown", ""]
    return "\n".join(lines) + "\n" + (ROOT / table["readme"]).read_text()


def tag():
    """Interpreter, ABI and platform that the extension fits."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{re.sub(r'[^A-Za-z0-9]', '_', sysconfig.get_platform())}"


def wheel_text():
    return f"Wheel-Version: 1.0\nGenerator: turnscale_build\nRoot-Is-Purelib: false\nTag: {tag()}\n"


def call(*command):
    print("+", *command, flush=True)
    result = subprocess.run([str(word) for word in command], cwd=ROOT)
    if result.returncode:
        sys.exit(f"turnscale: '{command[0]} {command[1]}' failed; its messages are above. Missing packages: "
                 "scripts/install-dependencies --python")


def install_into(folder, settings):
    if not shutil.which("cmake"):
        sys.exit("turnscale: cmake is missing; run scripts/install-dependencies --python")
    options = {"CMAKE_BUILD_TYPE": "Release", "CMAKE_UNITY_BUILD": "ON", "CMAKE_UNITY_BUILD_BATCH_SIZE": "12",
               "TURNSCALE_BUILD_PYTHON": "ON", "TURNSCALE_BUILD_TESTS": "OFF", "TURNSCALE_BUILD_SIMULATION": "OFF",
               "TURNSCALE_BUILD_LABORATORY": "OFF", "TURNSCALE_WARNINGS_AS_ERRORS": "OFF",
               "Python_EXECUTABLE": sys.executable}
    defines = "cmake.define."
    options.update({name[len(defines):]: value for name, value in settings.items() if name.startswith(defines)})
    if shutil.which("ccache"):
        options["CMAKE_CXX_COMPILER_LAUNCHER"] = str(ROOT / "cmake" / "compile-cached")
    generator = ["-G", "Ninja"] if shutil.which("ninja") else []
    # What another interpreter's build has found must not stay.
    interpreter = BUILD / "interpreter.txt"
    fresh = [] if interpreter.exists() and interpreter.read_text() == sys.version else ["--fresh"]
    call("cmake", "-S", ROOT, "-B", BUILD, *fresh, *generator, *(f"-D{name}={value}" for name, value in options.items()))
    interpreter.write_text(sys.version)
    call("cmake", "--build", BUILD, "--target", "turnscale_python", "--parallel", os.cpu_count())
    call("cmake", "--install", BUILD, "--component", "python", "--prefix", folder, "--strip")


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    table = project()
    name = f"{table['name']}-{table['version']}.dist-info"
    folder = pathlib.Path(metadata_directory) / name
    folder.mkdir(parents=True)
    (folder / "METADATA").write_text(metadata_text(table))
    (folder / "WHEEL").write_text(wheel_text())
    return name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    table = project()
    stem = f"{table['name']}-{table['version']}"
    name = f"{stem}-{tag()}.whl"
    with tempfile.TemporaryDirectory() as scratch:
        staged = pathlib.Path(scratch)
        install_into(staged, config_settings or {})
        files = {path.relative_to(staged).as_posix(): path.read_bytes()
                 for path in sorted(staged.rglob("*")) if path.is_file()}
    files[f"{stem}.dist-info/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    files[f"{stem}.dist-info/METADATA"] = metadata_text(table).encode()
    files[f"{stem}.dist-info/WHEEL"] = wheel_text().encode()
    record = f"{stem}.dist-info/RECORD"
    lines = []
    for path, data in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        lines.append(f"{path},sha256={digest},{len(data)}\n")
    files[record] = "".join(lines + [f"{record},,\n"]).encode()
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():
            entry = zipfile.ZipInfo(path, EPOCH)
            entry.external_attr = (0o755 if path.endswith(".so") else 0o644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            wheel.writestr(entry, data)
    return name


def build_sdist(sdist_directory, config_settings=None):
    table = project()
    stem = f"{table['name']}-{table['version']}"
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True).stdout
    with tempfile.TemporaryDirectory() as scratch, \
         tarfile.open(pathlib.Path(sdist_directory) / f"{stem}.tar.gz", "w:gz", format=tarfile.PAX_FORMAT) as archive:
        information = pathlib.Path(scratch) / "PKG-INFO"
        information.write_text(metadata_text(table))
        archive.add(information, f"{stem}/PKG-INFO")
        for path in filter(None, listed.decode().split("\0")):
            archive.add(ROOT / path, f"{stem}/{path}")
    return f"{stem}.tar.gz"
