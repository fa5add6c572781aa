# Builds <build>/fmus/<Model>.fmu for every file of models/:
#   describe_model -> description.json -> modelDescription.xml, GUID = hash of it -> binary that knows it -> zip.
# And the sources of FMUs of files.

add_executable(describe_model modelDescription/describe_model.cpp)
target_link_libraries(describe_model PRIVATE sigmafmu_describe sigmafmu_mechanisms)

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
set(contents tools/sigmafmu/contents)
file(GLOB SIGMAFMU_CONTENTS CONFIGURE_DEPENDS ${contents}/*.py ${contents}/templates/* ${contents}/licenses/*
     models/errors/*.csv tests/references/*.csv)
list(APPEND SIGMAFMU_CONTENTS tools/fmu_contents.py docs/mechanisms.md docs/fmi.md docs/method.md LICENSE)
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

  set(names models/${model}.cpp model.cpp ${SIGMAFMU_SOURCE_NAMES})
  add_custom_command(
    OUTPUT ${work}/description.json ${work}/model.cpp ${work}/mechanism.json ${tree}/modelDescription.xml
    COMMAND describe_model ${model} ${resources} ${work}/description.json
    COMMAND ${Python_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/tools/fmu_contents.py description ${work} --tree ${tree}
            "--source=$<JOIN:${names},;--source=>"
    DEPENDS describe_model tools/fmu_contents.py ${contents}/description.py ${contents}/model_description.py
            ${resource_files}
    COMMENT "Writing modelDescription.xml of ${model}"
    VERBATIM COMMAND_EXPAND_LISTS)

  sigmafmu_add_binary(${model} ${work}/model.cpp $<TARGET_OBJECTS:sigmafmu_fmi2>)
  target_link_libraries(${model} PRIVATE sigmafmu_slave sigmafmu_models)
  set_target_properties(${model} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${tree}/binaries/${FMI2_PLATFORM})

  set(sources ${CMAKE_CURRENT_SOURCE_DIR}/models/${model}.cpp ${work}/model.cpp ${SIGMAFMU_BINARY_SOURCES})
  add_custom_command(
    OUTPUT ${tree}/sources/buildDescription.xml
    COMMAND ${Python_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/tools/fmu_sources.py ${model} --output ${tree}/sources
            --own=models/${model}.cpp --own=model.cpp
            "--root=$<JOIN:${SIGMAFMU_SOURCE_ROOTS},;--root=>" --root=${work} ${sources}
    DEPENDS tools/fmu_sources.py cmake/FmuBinary.cmake cmake/fmi2.map cmake/source_fmu.cmake.in
            ${sources} ${SIGMAFMU_HEADERS}
    COMMENT "Collecting the sources of ${model}"
    VERBATIM COMMAND_EXPAND_LISTS)

  add_custom_command(
    OUTPUT ${tree}/documentation/index.html
    COMMAND ${Python_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/tools/fmu_contents.py contents ${work} --tree ${tree}
            --resources ${resources}
    DEPENDS ${SIGMAFMU_CONTENTS} ${work}/description.json ${resource_files}
    COMMENT "Writing the documentation of ${model}"
    VERBATIM)

  set(copied)
  foreach(file IN LISTS resource_files ITEMS ${work}/mechanism.json)  # the last is what `sigmafmu view` draws
    cmake_path(GET file FILENAME name)
    add_custom_command(
      OUTPUT ${tree}/resources/${name}
      COMMAND ${CMAKE_COMMAND} -E copy ${file} ${tree}/resources/${name}
      DEPENDS ${file}
      COMMENT "Copying ${name} of ${model}"
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

# --- FMUs of files ---------------------------------------------------------------------------------------------------

set(own fmi/model_of_file.cpp fmi/definition_checksum.cpp model/json.cpp)
list(TRANSFORM own PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/fmu_src/ OUTPUT_VARIABLE sources)
list(APPEND sources ${SIGMAFMU_BINARY_SOURCES})
add_custom_command(
  OUTPUT ${SIGMAFMU_SLAVE_DIR}/sources/buildDescription.xml
  COMMAND ${Python_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/tools/fmu_sources.py @MODEL@
          --output ${SIGMAFMU_SLAVE_DIR}/sources "--own=$<JOIN:${own},;--own=>"
          "--root=$<JOIN:${SIGMAFMU_SOURCE_ROOTS},;--root=>" ${sources}
  DEPENDS tools/fmu_sources.py cmake/FmuBinary.cmake cmake/fmi2.map cmake/source_fmu.cmake.in ${sources}
          ${SIGMAFMU_HEADERS}
  COMMENT "Collecting the sources of FMUs of files"
  VERBATIM COMMAND_EXPAND_LISTS)
add_custom_target(slave_sources ALL DEPENDS ${SIGMAFMU_SLAVE_DIR}/sources/buildDescription.xml)
install(DIRECTORY ${SIGMAFMU_SLAVE_DIR}/ DESTINATION sigmafmu/slave)
