// The whole program bulkley, with one law more: run, check, rheometer and all other subcommands know it.

#include <bulkley/program.hpp>

#include "carreau.hpp"

int main(int argc, char** argv) {
  bulkley::add_law<Carreau>();
  return bulkley::run_program(argc, argv);
}
