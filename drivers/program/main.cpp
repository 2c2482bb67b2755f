#include "bulkley/program.hpp"

int main(int argc, char** argv) { return bulkley::run_program(argc, argv); }
