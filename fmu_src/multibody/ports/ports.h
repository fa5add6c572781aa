// The ports of a mechanism: inputs, outputs and parameters, each told by the element that it belongs to.
//
// The FMU's variables, modelDescription.xml, getters and setters, terminals and documentation all come from them.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/mechanism.h"
#include "model/settings_table.h"
#include "model/units.h"
#include "multibody/system.h"

namespace sigmafmu {

// What outputs are computed from: one consistent point and all that follows from it.
struct View {
  const Mechanism& mechanism;
  const System& system;
  const VectorXd& q;
  const VectorXd& v;
  const Inputs& inputs;          // angles are counted near those of inputs.turned
  const Evaluation& evaluation;  // at (q, v)
  const VectorXd& vdot;          // index-1 accelerations and multipliers; valid if the port needs them
  const VectorXd& lambda;
};

enum class Causality { parameter, input, output, local };
enum class Variability { fixed, tunable, continuous, discrete };

// The elements that ports belong to.
struct Owner {
  std::string name;      // of the element; empty: the whole mechanism
  std::string kind;      // body, joint, force, station or sensor; else empty
  std::string type;      // of its kind
  std::string terminal;  // what other FMUs connect to it for; empty: nothing
};

struct Port {
  std::string name;
  std::string description;
  Causality causality = Causality::output;
  Variability variability = Variability::continuous;
  const RealType* type = nullptr;  // null for integers
  const char* unit = nullptr;      // of that type
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool above_min = false;  // min itself is not allowed
  bool integer = false;    // Integer or Enumeration
  const Enumeration* enumeration = nullptr;
  int owner = -1;            // in Ports::owners()
  bool in_terminal = false;  // what other FMUs connect to
  // Only outputs with one of these can depend on inputs.
  bool needs_accelerations = false;  // reads View::vdot or View::lambda
  bool times_velocity = false;       // a power: inputs or multipliers times velocities

  // Where the value is: a parameter lies in a Mechanism, an input in the vector u. Outputs are computed in groups, such
  // as the six scalars of a joint's reaction: `output` writes the values of the group, which OutputValues keeps from
  // `group` on, and this is the one at `component`.
  int object = 0, port = 0, component = 0, group = 0;
  void (*output)(const View&, int object, int port, double* values) = nullptr;
  double (*rate)(const View&, int object, int component) = nullptr;  // its time derivative, if the output may jump
  double& (*parameter)(Mechanism&, int object, int port, int component) = nullptr;
  int& (*option)(Mechanism&, int object) = nullptr;  // of an integer parameter
  std::optional<InitialValue> initial;               // which of the definition's a parameter is
  int input = -1;                                    // in u
  int prescribed = -1;                               // of an input that is prescribed: in Inputs::x
  int derivative = 0;                                // and which derivative of that
  double start = 0;                                  // of an input

  bool is_input() const { return input >= 0 || prescribed >= 0; }

  double value(const Mechanism& mechanism) const;  // of a parameter
  void set_value(Mechanism& mechanism, double value) const;
  // Empty, or one sentence that says what is wrong with a value.
  std::string complaint(double value) const;
};

// Outputs at one point: each group is computed once, when the first of its values is asked for. Allocates nothing after
// the construction.
class OutputValues {
 public:
  explicit OutputValues(const std::vector<Port>& ports);
  double operator()(const Port& port, const View& view);  // of an output
  void forget();                                          // the point has changed

 private:
  std::vector<double> values_;
  std::vector<char> known_;  // by the first value of a group
};

// Where elements tell their ports. Vectors are told as a whole; their elements are named [1], [2], ...
class Ports {
 public:
  Ports(const Mechanism& mechanism, const System& system) : mechanism(mechanism), system(system) {}

  using Output = void (*)(const View&, int object, int port, double* values);
  using Rate = double (*)(const View&, int object, int component);
  using Parameter = double& (*)(Mechanism&, int object, int port, int component);

  const Mechanism& mechanism;
  const System& system;

  // What is told from here on belongs to it; an owner that is there already is taken again.
  void owner(const std::string& name, const std::string& kind, const std::string& type);
  // Outputs that are computed together.
  struct Group {
    int object, port;
    Output compute;
    bool needs_accelerations;
    int start;  // among the values of all outputs
  };
  Group group(int object, int size, Output compute, bool needs_accelerations = false, int port = 0);
  Port& output(const Group& group, int component, const std::string& name, const char* type,
               const std::string& description);
  void outputs(const Group& group, int first, const std::string& name, int count, const char* type,
               const std::string& description, Rate rate = nullptr);
  // A vector or scalar that is a group of its own.
  void outputs(int object, const std::string& name, int count, const char* type, const std::string& description,
               Output compute, bool needs_accelerations = false);
  Port& output(int object, const std::string& name, const char* type, const std::string& description, Output compute);
  Port& parameter(int object, const std::string& name, const char* type, const std::string& description,
                  Parameter access, Variability variability);
  void parameters(int object, const std::string& name, int count, const char* type, const std::string& description,
                  Parameter access, Variability variability);
  void initial(InitialValue what, const std::string& suffix, const char* type, const std::string& description);
  void initial_vector(InitialValue what, int count, const char* type, const std::string& description);
  void input(int index, const std::string& name, const char* type, const std::string& description);
  void inputs(int first, const std::string& name, int count, const char* type, const std::string& description);
  // `derivative` of what is prescribed at `index`.
  void prescribed(int index, int derivative, const std::string& name, const char* type, const std::string& description,
                  double start);
  Port& add(std::string name, const char* type, std::string description);

  // Which row of its element's table the ports from `first` on have.
  void set_port(std::size_t first, int row);
  // Of the ports from `first` on.
  void set_times_velocity(std::size_t first);
  // Ports of the present owner that other FMUs connect to, by the names of their vectors, and what for.
  void terminal(const std::string& purpose, const std::vector<std::string>& members);

  const std::vector<Port>& ports() const { return ports_; }
  const std::vector<Owner>& owners() const { return owners_; }
  std::vector<Port> take() { return std::move(ports_); }

 private:
  std::vector<Port> ports_;
  std::vector<Owner> owners_;
  int owner_ = -1;
  int output_count_ = 0;
};

// What a port is, then what its element's definition says about it, if anything.
std::string with_note(const std::string& text, const std::string& note);

inline Eigen::Map<Vector3d> vector3(double* values) { return Eigen::Map<Vector3d>(values); }

// Those of each kind of element.
void body_ports(Ports& ports, int body);
void joint_ports(Ports& ports, int joint);
void drive_ports(Ports& ports, int drive);
void coupling_ports(Ports& ports, int coupling);
void motion_ports(Ports& ports, int motion);
void force_ports(Ports& ports);  // of all forces
void station_ports(Ports& ports, int station);
void sensor_ports(Ports& ports, int i);
void system_ports(Ports& ports);  // of the whole mechanism

}  // namespace sigmafmu
