// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>

int main(int argc, char** argv) {
  CLI::App app{"turnscale: the path of a car in metres, from one camera"};
  app.require_subcommand(1);
  CLI11_PARSE(app, argc, argv);
  return 0;
}
