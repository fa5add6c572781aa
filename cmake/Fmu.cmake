# Builds <build>/fmus/<Model>.fmu for every file of models/:
#   write_model_description -> modelDescription.xml without GUID -> GUID = hash of it -> binary that knows it -> zip.

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

add_executable(write_model_description modelDescription/write.cpp modelDescription/dependencies.cpp)
target_link_libraries(write_model_description PRIVATE sigmafmu_slave sigmafmu_json sigmafmu_mechanisms tinyxml2::tinyxml2)
target_compile_definitions(write_model_description PRIVATE SIGMAFMU_VERSION="${PROJECT_VERSION}")

# Where include paths start; the folder `sources` of an FMU holds what is included from here.
get_target_property(eigen_dir Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
set(SIGMAFMU_SOURCE_ROOTS ${CMAKE_CURRENT_SOURCE_DIR}/fmu_src ${CMAKE_CURRENT_SOURCE_DIR} ${eigen_dir} ${FMI2_INCLUDE_DIR}
    ${NLOHMANN_JSON_INCLUDE_DIR})

# All C++ files of an FMU but the mechanism's own.
set(SIGMAFMU_BINARY_SOURCES)
foreach(target sigmafmu_core sigmafmu_slave sigmafmu_fmi2)
  get_target_property(files ${target} SOURCES)
  list(APPEND SIGMAFMU_BINARY_SOURCES ${files})
endforeach()
list(TRANSFORM SIGMAFMU_BINARY_SOURCES REPLACE "^fmu_src/" "" OUTPUT_VARIABLE SIGMAFMU_SOURCE_NAMES)
list(TRANSFORM SIGMAFMU_BINARY_SOURCES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
file(GLOB SIGMAFMU_CONTENTS CONFIGURE_DEPENDS tools/fmu_contents/*.py tools/fmu_contents/templates/*
     tools/fmu_contents/licenses/* models/errors/*.csv tests/references/*.csv)
list(APPEND SIGMAFMU_CONTENTS docs/mechanisms.md docs/fmi.md docs/method.md LICENSE)
file(GLOB_RECURSE SIGMAFMU_HEADERS CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/fmu_src/*.h
     ${CMAKE_CURRENT_SOURCE_DIR}/models/*.h)

set(SIGMAFMU_FMU_DIR ${CMAKE_CURRENT_BINARY_DIR}/fmus)
file(MAKE_DIRECTORY ${SIGMAFMU_FMU_DIR})
set(SIGMAFMU_FMUS)

foreach(model IN LISTS SIGMAFMU_MODELS)
  set(work ${CMAKE_CURRENT_BINARY_DIR}/fmu/${model})
  set(tree ${work}/tree)
  file(MAKE_DIRECTORY ${tree}/binaries/${FMI2_PLATFORM})
  set(resources ${CMAKE_CURRENT_SOURCE_DIR}/models/resources/${model})
  file(GLOB resource_files CONFIGURE_DEPENDS ${resources}/*)

  add_custom_command(
    OUTPUT ${work}/model.cpp ${work}/mechanism.json ${work}/elements.json ${tree}/modelDescription.xml
    COMMAND write_model_description ${model} ${work} ${resources}
            models/${model}.cpp model.cpp ${SIGMAFMU_SOURCE_NAMES}
    COMMAND ${CMAKE_COMMAND} -D MODEL=${model} -D BLANK=${work}/modelDescription.xml
            -D XML=${tree}/modelDescription.xml -D SOURCE=${work}/model.cpp
            -P ${CMAKE_CURRENT_SOURCE_DIR}/cmake/WriteGuid.cmake
    DEPENDS write_model_description cmake/WriteGuid.cmake ${resource_files}
    COMMENT "Writing modelDescription.xml of ${model}"
    VERBATIM)

  sigmafmu_add_binary(${model} ${work}/model.cpp $<TARGET_OBJECTS:sigmafmu_fmi2>)
  target_link_libraries(${model} PRIVATE sigmafmu_slave sigmafmu_models)
  set_target_properties(${model} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${tree}/binaries/${FMI2_PLATFORM})

  set(sources ${CMAKE_CURRENT_SOURCE_DIR}/models/${model}.cpp ${work}/model.cpp ${SIGMAFMU_BINARY_SOURCES})
  add_custom_command(
    OUTPUT ${tree}/sources/buildDescription.xml
    COMMAND ${Python_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/tools/fmu_sources.py ${model} --output ${tree}/sources
            "--root=$<JOIN:${SIGMAFMU_SOURCE_ROOTS},;--root=>" --root=${work} ${sources}
    DEPENDS tools/fmu_sources.py cmake/FmuBinary.cmake cmake/fmi2.map cmake/source_fmu.cmake.in
            ${sources} ${SIGMAFMU_HEADERS}
    COMMENT "Collecting the sources of ${model}"
    VERBATIM COMMAND_EXPAND_LISTS)

  add_custom_command(
    OUTPUT ${tree}/documentation/index.html
    COMMAND ${Python_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/tools/fmu_contents ${model}
            --model-description ${tree}/modelDescription.xml
            --mechanism ${work}/mechanism.json --elements ${work}/elements.json --resources ${resources}
            --references ${CMAKE_CURRENT_SOURCE_DIR}/tests/references --output ${tree}
    DEPENDS ${SIGMAFMU_CONTENTS} ${tree}/modelDescription.xml ${work}/mechanism.json ${work}/elements.json ${resource_files}
    COMMENT "Writing the documentation of ${model}"
    VERBATIM)

  set(copied)
  foreach(file IN LISTS resource_files)
    cmake_path(GET file FILENAME name)
    add_custom_command(
      OUTPUT ${tree}/resources/${name}
      COMMAND ${CMAKE_COMMAND} -E copy ${file} ${tree}/resources/${name}
      DEPENDS ${file}
      COMMENT "Copying the modal data of ${model}"
      VERBATIM)
    list(APPEND copied ${tree}/resources/${name})
  endforeach()

  set(fmu ${SIGMAFMU_FMU_DIR}/${model}.fmu)
  add_custom_command(
    OUTPUT ${fmu}
    COMMAND ${CMAKE_COMMAND} -E tar cf ${fmu} --format=zip .
    WORKING_DIRECTORY ${tree}
    DEPENDS ${model} ${tree}/modelDescription.xml ${tree}/sources/buildDescription.xml
            ${tree}/documentation/index.html ${copied}
    COMMENT "Packing ${model}.fmu"
    VERBATIM)
  list(APPEND SIGMAFMU_FMUS ${fmu})
endforeach()

add_custom_target(fmus ALL DEPENDS ${SIGMAFMU_FMUS})
install(FILES ${SIGMAFMU_FMUS} DESTINATION sigmafmu/fmus)
