// A mechanism as a co-simulation slave: phases, values, communication steps, snapshots. Knows no FMI version.
//
// Every call either does what it says or throws and leaves the slave as it was: Refused for a request that cannot be
// met (wrong value, wrong variable), Discarded for a computation that did not succeed. do_step reports by its result,
// because part of a step may have been done. A Slave shares nothing with others: one thread at a time per slave.
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>

#include "fmi/snapshot.h"
#include "fmi/variables.h"
#include "integrator/integrator.h"
#include "solve/start/assembly.h"

namespace sigmafmu {

struct Refused : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct Discarded : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Slave {
 public:
  enum class Report { event, warning };
  using Reporter = std::function<void(Report, const std::string&)>;

  Slave(Mechanism defaults, std::string identity, Reporter report);

  bool reports_events = false;  // whether Report::event is wanted: making its text allocates

  Phase phase() const { return data_.phase; }
  const std::vector<Variable>& variables() const { return variables_; }

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
  const std::string& message() const { return message_; }

  Snapshot save() const;
  void restore(const Snapshot& snapshot);
  const std::string& identity() const { return identity_; }

 private:
  // All that is built from the parameters.
  struct Engine {
    System system;
    ConsistentSolver solver;
    std::unique_ptr<Integrator> integrator;
    Engine(const MultibodyDef& multibody, const IntegratorSettings& settings, KktPlans plans)
        : system(multibody), solver(system, plans), integrator(make_integrator(system, settings, plans)) {}
  };
  // Outputs of one point, computed as far as asked for.
  struct Outputs {
    Evaluation evaluation;
    VectorXd vdot, lambda, u;
    bool has_motion = false, has_accelerations = false;
  };

  const Variable& variable(unsigned reference) const;
  const Variable& real_output(unsigned reference, const char* purpose) const;
  void read_parameters();
  bool apply_parameters(const std::vector<double>& values);
  IntegratorSettings settings() const;
  void build();
  void initialize();
  void ensure_initialized();
  void require_settable(const Variable& v) const;
  void evaluate(bool accelerations);
  void accelerations_or_discard(const VectorXd& q, const VectorXd& v, const VectorXd& u, VectorXd& vdot,
                                VectorXd& lambda);
  View view() const;
  void absorb_jump();
  void warn_about_initial_values() const;
  void warn_about_settings();
  void warn_about_accuracy(double t, double h);
  void describe_failure(const StepFailure& failure);
  std::string describe_position();

  KktPlans plans_;  // of every engine: parameters do not change the topology
  const Mechanism defaults_;
  const std::string identity_;
  Reporter report_;
  Mechanism mechanism_;
  std::vector<Variable> variables_;
  std::vector<unsigned> parameter_references_;
  std::unique_ptr<Engine> engine_;
  Snapshot data_;
  Outputs outputs_;
  VectorXd vdot_before_, vdot_after_, lambda_scratch_;
  std::string message_;
  bool warned_of_error_ = false, warned_of_spin_ = false;
};

}  // namespace sigmafmu
