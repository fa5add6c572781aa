# Builds <build>/fmus/<Model>.fmu for every file of models/:
#   write_model_description -> modelDescription.xml without GUID -> GUID = hash of it -> binary that knows it -> zip.

add_library(sigmafmu_slave STATIC
  fmu_src/fmi/slave.cpp
  fmu_src/fmi/snapshot.cpp
  fmu_src/fmi/units.cpp
  fmu_src/fmi/variables.cpp)
target_link_libraries(sigmafmu_slave PUBLIC sigmafmu_core)

add_library(sigmafmu_fmi2 OBJECT fmu_src/fmi/fmi2_functions.cpp)
target_link_libraries(sigmafmu_fmi2 PUBLIC sigmafmu_slave)
target_include_directories(sigmafmu_fmi2 SYSTEM PUBLIC ${FMI2_INCLUDE_DIR})

add_executable(write_model_description modelDescription/write.cpp modelDescription/dependencies.cpp)
target_link_libraries(write_model_description PRIVATE sigmafmu_slave sigmafmu_mechanisms tinyxml2::tinyxml2)
target_compile_definitions(write_model_description PRIVATE SIGMAFMU_VERSION="${PROJECT_VERSION}")

# FMI's name of this platform.
if(CMAKE_SIZEOF_VOID_P EQUAL 8)
  set(bits 64)
else()
  set(bits 32)
endif()
if(WIN32)
  set(FMI2_PLATFORM win${bits})
elseif(APPLE)
  set(FMI2_PLATFORM darwin${bits})
else()
  set(FMI2_PLATFORM linux${bits})
endif()

set(SIGMAFMU_FMU_DIR ${CMAKE_CURRENT_BINARY_DIR}/fmus)
file(MAKE_DIRECTORY ${SIGMAFMU_FMU_DIR})
set(SIGMAFMU_FMUS)

foreach(model IN LISTS SIGMAFMU_MODELS)
  set(work ${CMAKE_CURRENT_BINARY_DIR}/fmu/${model})
  set(tree ${work}/tree)
  file(MAKE_DIRECTORY ${tree}/binaries/${FMI2_PLATFORM})

  add_custom_command(
    OUTPUT ${work}/model.cpp ${tree}/modelDescription.xml
    COMMAND write_model_description ${model} ${work}/modelDescription.xml
    COMMAND ${CMAKE_COMMAND} -D MODEL=${model} -D BLANK=${work}/modelDescription.xml
            -D XML=${tree}/modelDescription.xml -D SOURCE=${work}/model.cpp
            -P ${CMAKE_CURRENT_SOURCE_DIR}/cmake/WriteGuid.cmake
    DEPENDS write_model_description cmake/WriteGuid.cmake
    COMMENT "Writing modelDescription.xml of ${model}"
    VERBATIM)

  add_library(${model} MODULE ${work}/model.cpp $<TARGET_OBJECTS:sigmafmu_fmi2>)
  target_link_libraries(${model} PRIVATE sigmafmu_slave sigmafmu_models)
  set_target_properties(${model} PROPERTIES
    PREFIX "" LIBRARY_OUTPUT_DIRECTORY ${tree}/binaries/${FMI2_PLATFORM})
  # Nothing but fmi2* leaves the library: no clash with other FMUs in the process.
  if(NOT APPLE AND NOT WIN32)
    target_link_options(${model} PRIVATE
      -Wl,--version-script=${CMAKE_CURRENT_SOURCE_DIR}/cmake/fmi2.map -Wl,--gc-sections)
    set_target_properties(${model} PROPERTIES LINK_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/cmake/fmi2.map)
  endif()

  set(fmu ${SIGMAFMU_FMU_DIR}/${model}.fmu)
  add_custom_command(
    OUTPUT ${fmu}
    COMMAND ${CMAKE_COMMAND} -E tar cf ${fmu} --format=zip modelDescription.xml binaries
    WORKING_DIRECTORY ${tree}
    DEPENDS ${model} ${tree}/modelDescription.xml
    COMMENT "Packing ${model}.fmu"
    VERBATIM)
  list(APPEND SIGMAFMU_FMUS ${fmu})
endforeach()

add_custom_target(fmus ALL DEPENDS ${SIGMAFMU_FMUS})
install(FILES ${SIGMAFMU_FMUS} DESTINATION sigmafmu/fmus)
