// What a mechanism tells of one of its points.
//
// A motion sensor measures how its frame moves, seen from a reference frame of the ground or of a body: by an observer
// who stands there and turns with it. An inertial sensor (IMU) measures specific force and angular velocity of its
// frame, in its axes.
#pragma once

#include <string>
#include <vector>

#include "model/elements/frame.h"

namespace sigmafmu {

enum class SensorType { motion, imu };
// In which axes a motion sensor's vectors are: W's, the reference frame's or its own.
enum class SensorAxes { ground, reference, sensor };
// In the order of the enumerations.
const std::vector<std::string>& sensor_type_names();
const std::vector<std::string>& sensor_axes_names();

struct SensorDef {
  std::string name;
  std::string description;
  SensorType type = SensorType::motion;
  int body = kGround;
  Frame frame;
  int reference = kGround;  // a body; of a motion sensor
  Frame reference_frame;
  SensorAxes axes = SensorAxes::reference;
};

}  // namespace sigmafmu
