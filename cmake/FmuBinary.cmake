# What every build of an FMU's binary shares: this project's own and the one from the FMU's sources folder.

# The same bits on every machine: no contraction to fused multiply-add. Neither errno nor traps are used.
if(MSVC)
  set(SIGMAFMU_COMPILE_OPTIONS /O2 /fp:precise)
else()
  set(SIGMAFMU_COMPILE_OPTIONS -ffp-contract=off -fno-math-errno -fno-trapping-math $<$<CONFIG:Release>:-O3>)
endif()

set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)

# What runs at the start alone is not worth a compiler's time: half of it goes. Results are the same bits.
function(sigmafmu_optimize_start_little folder)
  if(MSVC)
    return()
  endif()
  foreach(file model/eigenvalues.cpp model/json.cpp model/modal_constants.cpp model/modal_file.cpp model/validate_modal.cpp
               solve/order.cpp solve/start/assembly.cpp solve/start/contradiction.cpp solve/start/dependence_texts.cpp
               solve/start/dependent_equations.cpp solve/start/determined_motion.cpp solve/start/held_projection.cpp
               solve/start/held_refusal.cpp solve/start/least_squares.cpp solve/start/row_space.cpp
               solve/start/scaled_equations.cpp
               fmi/variables.cpp)
    set_property(SOURCE ${folder}${file} PROPERTY COMPILE_OPTIONS $<$<CONFIG:Release>:-O1>)
  endforeach()
endfunction()

# FMI's name of the platform.
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

set(SIGMAFMU_SYMBOLS ${CMAKE_CURRENT_LIST_DIR}/fmi2.map)

# A library without a prefix that shows nothing but the symbols of a map: no clash with others in the process.
function(sigmafmu_add_library name symbols)
  add_library(${name} MODULE ${ARGN})
  set_target_properties(${name} PROPERTIES PREFIX "")
  if(NOT APPLE AND NOT WIN32)
    target_link_options(${name} PRIVATE -Wl,--version-script=${symbols} -Wl,--gc-sections)
    set_target_properties(${name} PROPERTIES LINK_DEPENDS ${symbols})
  elseif(APPLE)
    set_target_properties(${name} PROPERTIES SUFFIX .dylib)
  endif()
endfunction()

# The binary of an FMU, named like the model.
function(sigmafmu_add_binary model)
  sigmafmu_add_library(${model} ${SIGMAFMU_SYMBOLS} ${ARGN})
endfunction()
