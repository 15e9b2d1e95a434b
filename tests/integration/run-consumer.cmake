# cmake -D BUILD_DIR=... -D CONSUMER_DIR=... -D GENERATOR=... -D CXX_COMPILER=... -D BUILD_TYPE=... -D CXX_FLAGS=...
#       -P run-consumer.cmake
# Installs ceilmap below its build folder, then configures, builds and runs a project that uses the package.
set(stage ${BUILD_DIR}/consumer-test)
file(REMOVE_RECURSE ${stage})

execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${stage}/prefix
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${stage}/build -G ${GENERATOR}
  -D CMAKE_PREFIX_PATH=${stage}/prefix -D CMAKE_CXX_COMPILER=${CXX_COMPILER} -D CMAKE_BUILD_TYPE=${BUILD_TYPE}
  -D CMAKE_CXX_FLAGS=${CXX_FLAGS}
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${stage}/build COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${stage}/build/consumer COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${stage}/build/simulator_consumer COMMAND_ERROR_IS_FATAL ANY)
