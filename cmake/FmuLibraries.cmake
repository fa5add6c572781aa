# What FMUs are linked from, and the two libraries of FMUs of files: the slave that reads its mechanism, and the library that
# describes it.

add_library(sigmafmu_slave STATIC
  fmu_src/fmi/instance.cpp
  fmu_src/fmi/remarks.cpp
  fmu_src/fmi/resources.cpp
  fmu_src/fmi/slave.cpp
  fmu_src/fmi/slave_derivatives.cpp
  fmu_src/fmi/slave_step.cpp
  fmu_src/fmi/snapshot.cpp
  fmu_src/fmi/variables.cpp)
target_link_libraries(sigmafmu_slave PUBLIC sigmafmu_core)

add_library(sigmafmu_fmi2 OBJECT fmu_src/fmi/fmi2_functions.cpp fmu_src/fmi/unload.cpp)
target_link_libraries(sigmafmu_fmi2 PUBLIC sigmafmu_slave)
target_include_directories(sigmafmu_fmi2 SYSTEM PUBLIC ${FMI2_INCLUDE_DIR})

add_library(sigmafmu_file_model STATIC fmu_src/fmi/definition_checksum.cpp fmu_src/fmi/set_parameter.cpp)
target_link_libraries(sigmafmu_file_model PUBLIC sigmafmu_slave sigmafmu_json)

add_library(sigmafmu_describe STATIC modelDescription/describe.cpp modelDescription/dependencies.cpp modelDescription/start.cpp)
target_link_libraries(sigmafmu_describe PUBLIC sigmafmu_file_model)
target_include_directories(sigmafmu_describe SYSTEM PUBLIC ${NLOHMANN_JSON_INCLUDE_DIR})
target_compile_definitions(sigmafmu_describe PRIVATE SIGMAFMU_VERSION="${PROJECT_VERSION}")

set(SIGMAFMU_SLAVE_DIR ${CMAKE_CURRENT_BINARY_DIR}/slave)
sigmafmu_add_binary(slave fmu_src/fmi/model_of_file.cpp $<TARGET_OBJECTS:sigmafmu_fmi2>)
target_link_libraries(slave PRIVATE sigmafmu_file_model)
sigmafmu_add_library(describe ${CMAKE_CURRENT_SOURCE_DIR}/cmake/describe.map modelDescription/describe_library.cpp
                     fmu_src/fmi/unload.cpp)
target_link_libraries(describe PRIVATE sigmafmu_describe)
set_target_properties(slave describe PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${SIGMAFMU_SLAVE_DIR}/${FMI2_PLATFORM})
