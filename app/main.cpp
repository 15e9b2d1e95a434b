#include "app/program.hpp"

int main(int argc, char** argv) {
  return ceilmap::app::RunProgram(argc, argv);
}
