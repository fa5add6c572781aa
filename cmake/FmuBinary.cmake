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

# Small files that include the same headers are compiled together, which saves the time of those, in targets with
# UNITY_BUILD_MODE GROUP.
function(sigmafmu_compile_together folder)
  set(definitions
      model/definition.cpp model/elements/bushing.cpp model/elements/cloud_contact.cpp
      model/elements/coupling.cpp model/elements/joint_stop.cpp model/elements/on_coordinate.cpp
      model/elements/references.cpp model/elements/rotation_motor.cpp model/elements/table_spring.cpp
      model/elements/tendon.cpp model/initial_values.cpp
      model/joint_types.cpp model/names.cpp model/settings_table.cpp model/units.cpp model/validate.cpp
      model/validate_body.cpp)
  set(elements
      multibody/constraints/coupling.cpp multibody/constraints/joint.cpp multibody/forces/coordinate_force.cpp
      multibody/forces/joint_armature.cpp multibody/forces/joint_friction.cpp
      multibody/forces/joint_spring.cpp multibody/forces/joint_stop.cpp multibody/forces/rotation_motor.cpp
      multibody/forces/spring_damper.cpp multibody/forces/tendon.cpp multibody/joint_coordinate.cpp
      multibody/momentum.cpp multibody/moving_frame.cpp multibody/point_motion.cpp)
  set(forces
      multibody/constraints/rolling_disk.cpp multibody/forces/bearing.cpp multibody/forces/bushing.cpp
      multibody/forces/cloud_contact.cpp
      multibody/forces/contact_force.cpp multibody/forces/drag.cpp multibody/forces/frame_pair_force.cpp
      multibody/forces/line_force.cpp multibody/forces/monotone_cubic.cpp multibody/forces/torsion_spring.cpp)
  set(ports
      multibody/ports/body_ports.cpp multibody/ports/force_ports.cpp multibody/ports/joint_ports.cpp
      multibody/ports/ports.cpp multibody/ports/sensor_ports.cpp multibody/ports/system_ports.cpp)
  set(methods
      integrator/implicit/newton.cpp integrator/implicit/step_ends.cpp integrator/integrator.cpp
      integrator/methods/bliedf.cpp integrator/methods/generalized_alpha.cpp
      integrator/methods/munthe_kaas.cpp integrator/printed/printed_algorithms.cpp integrator/problem.cpp
      integrator/step_control.cpp solve/kkt_layout.cpp)
  set(slave
      fmi/fmi2_functions.cpp fmi/instance.cpp fmi/remarks.cpp fmi/resources.cpp fmi/slave.cpp
      fmi/slave_derivatives.cpp fmi/slave_step.cpp fmi/snapshot.cpp)
  foreach(group definitions elements forces ports methods slave)
    list(TRANSFORM ${group} PREPEND "${folder}" OUTPUT_VARIABLE files)
    set_source_files_properties(${files} PROPERTIES UNITY_GROUP ${group})
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
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$")  # FMI 3.0's name; linux64 is that of x86-64
  set(FMI2_PLATFORM aarch64-linux)
else()
  set(FMI2_PLATFORM linux${bits})
endif()

set(SIGMAFMU_SYMBOLS ${CMAKE_CURRENT_LIST_DIR}/fmi2.map)

# A library without a prefix that shows nothing but the symbols of a map: no clash with others in the process.
function(sigmafmu_add_library name symbols)
  if(APPLE)
    add_library(${name} SHARED ${ARGN})  # Zig makes no bundles, and masters load either
  else()
    add_library(${name} MODULE ${ARGN})
  endif()
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
