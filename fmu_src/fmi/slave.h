// A mechanism as a co-simulation slave: phases, values, communication steps, snapshots. Knows no FMI version.
//
// Every call either does what it says or throws and leaves the slave as it was, also when memory runs out: Refused for
// a request that cannot be met (wrong value, wrong variable), Discarded for a computation that did not succeed. do_step
// reports by its result, because part of a step may have been done. A Slave shares nothing with others: one thread at a
// time per slave.
#pragma once

#include <memory>
#include <stdexcept>

#include "fmi/engine.h"
#include "fmi/remarks.h"
#include "fmi/snapshot.h"
#include "fmi/variables.h"

namespace sigmafmu {

struct Refused : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct Discarded : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Slave {
 public:
  // What is to be said beside the results of calls goes to `listener`, which outlives the slave; null: nowhere.
  Slave(Mechanism mechanism, std::string identity, Listener* listener = nullptr);

  Phase phase() const { return data_.phase; }
  const std::vector<Port>& variables() const { return variables_; }

  // tolerance 0: none. It is the error tolerance of methods that control their error, unless a parameter sets that.
  void setup_experiment(double start, bool has_stop, double stop, double tolerance);
  void enter_initialization();
  void exit_initialization();
  void terminate() { data_.phase = Phase::terminated; }
  void reset();

  // References are indices into variables(); integers, enumerations included, are apart from reals.
  void get(const unsigned* references, std::size_t count, bool integer, double* values);
  void set(const unsigned* references, std::size_t count, bool integer, const double* values);

  // order 1 or 2: derivatives of inputs at the beginning of the next communication step; back to 0 after it.
  void set_input_derivatives(const unsigned* references, std::size_t count, const int* orders, const double* values);
  // order 1: total time derivative of real outputs at the present point.
  void get_output_derivatives(const unsigned* references, std::size_t count, const int* orders, double* values);
  // d(outputs)/d(inputs) . direction at the present point.
  void directional_derivative(const unsigned* outputs, std::size_t output_count, const unsigned* inputs,
                              std::size_t input_count, const double* direction, double* derivative);

  // t -> t + H in n = ceil(H / stepSize) equal internal steps. False: the slave is at time(), the last good time, and
  // message() says what happened. Does not allocate unless something goes wrong.
  [[nodiscard]] bool do_step(double t, double H);
  double time() const { return data_.state.time; }
  const char* message() const { return message_.empty() ? kNoMemory : message_.c_str(); }

  Snapshot save() const { return data_; }
  void restore(const Snapshot& snapshot);
  // Bytes that another process with the same FMU can read.
  std::vector<char> serialize(const Snapshot& snapshot) const { return sigmafmu::serialize(snapshot, identity_); }
  // Throws Refused for bytes that are no state of this slave.
  Snapshot deserialize(const char* bytes, std::size_t size) const;

 private:
  // slave.cpp
  struct Changes {
    bool inputs = false, parameters = false;
  };
  void read_parameters(const Mechanism& mechanism, std::vector<double>& values) const;
  void set_parameters(Mechanism& mechanism, const std::vector<double>& values) const;
  bool same_fixed(const std::vector<double>& a, const std::vector<double>& b) const;
  IntegratorSettings settings(const Mechanism& mechanism, double tolerance) const;
  std::unique_ptr<Engine> make_engine(const Mechanism& mechanism, double tolerance) const;
  bool engine_fits(const Snapshot& data) const;
  void fit_engine(const Mechanism& mechanism, const Snapshot& data);
  Snapshot first_snapshot() const;
  void tell_prescribed();
  void initialize();
  void ensure_initialized();
  const Port& variable(unsigned reference) const;
  const Port& typed_variable(unsigned reference, bool integer, const char* done) const;
  void require_settable(const Port& v) const;
  Changes check_values(const unsigned* references, std::size_t count, bool integer, const double* values) const;
  void store_values(const unsigned* references, std::size_t count, const double* values);
  void remember_acceleration();
  void forget_outputs();
  void evaluate(bool accelerations);
  void accelerations_or_discard(const VectorXd& q, const VectorXd& v, const Inputs& u, VectorXd& vdot,
                                VectorXd& lambda);
  SlaveView view() const;
  // slave_derivatives.cpp
  const Port& real_output(unsigned reference, const char* purpose) const;
  // slave_step.cpp
  void check_step(double t, double H) const;
  void absorb_jump();
  void move_to_prescribed();
  bool internal_steps(double t, double H, std::int64_t n);
  void describe_failure(const StepFailure& failure) noexcept;
  std::string describe_position();

  const std::string identity_;
  KktPlans plans_;  // of every engine: parameters do not change the topology
  Mechanism mechanism_;
  const IntegratorSettings default_settings_;
  std::unique_ptr<Engine> engine_;
  // What the engine was built from.
  std::vector<double> engine_parameters_;
  double engine_tolerance_ = 0;

  std::vector<Port> variables_;
  std::vector<unsigned> parameter_references_;
  std::vector<double> default_parameters_;
  Snapshot data_;
  OutputValues outputs_;
  Remarks remarks_;
  std::string message_;
};

}  // namespace sigmafmu
