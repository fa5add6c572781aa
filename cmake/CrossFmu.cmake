# Another platform: the binaries alone, in <build>/fmus and <build>/slave. The build for this machine has written
# <SIGMAFMU_DESCRIBED>/<Model>/model.cpp, which tells the FMUs apart. tools/release.py runs this.

set(SIGMAFMU_DESCRIBED "" CACHE PATH "Folder of the model.cpp of each FMU")
foreach(model IN LISTS SIGMAFMU_MODELS)
  sigmafmu_add_binary(${model} ${SIGMAFMU_DESCRIBED}/${model}/model.cpp $<TARGET_OBJECTS:sigmafmu_fmi2>)
  target_link_libraries(${model} PRIVATE sigmafmu_slave sigmafmu_models)
  set_target_properties(${model} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/fmus
                                            RUNTIME_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/fmus)
endforeach()
add_custom_target(fmus DEPENDS ${SIGMAFMU_MODELS})

# Not the slave: `describe` needs its table of variables alone, and no model.cpp.
sigmafmu_compile_together(fmu_src/)
set_target_properties(sigmafmu_core PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
