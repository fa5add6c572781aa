#include "multibody/ports/ports.h"

#include <algorithm>
#include <cmath>

#include "text/text.h"

namespace sigmafmu {

double Port::value(const Mechanism& mechanism) const {
  if (initial) return initial_value(mechanism.multibody, *initial);
  Mechanism& m = const_cast<Mechanism&>(mechanism);  // the accessors serve reading and writing
  return option ? option(m, object) : parameter(m, object, port, component);
}

void Port::set_value(Mechanism& mechanism, double value) const {
  if (initial) {
    set_initial_value(mechanism.multibody, *initial, value);
  } else if (option) {
    option(mechanism, object) = static_cast<int>(value);
  } else {
    parameter(mechanism, object, port, component) = value;
  }
}

std::string Port::complaint(double value) const {
  const bool low = above_min ? !(value > min) : !(value >= min);
  if (std::isfinite(value) && !low && value <= max) return {};
  std::ostringstream text = text_stream();
  text << name << " is " << value;
  if (unit && std::string(unit) != "1") text << " " << unit;
  text << "; it must be ";
  if (enumeration) {
    for (std::size_t i = 0; i < enumeration->items.size(); ++i) {
      text << (i == 0                               ? ""
               : i + 1 == enumeration->items.size() ? " or "
                                                    : ", ")
           << i + 1 << " (" << enumeration->items[i].name << ")";
    }
  } else {
    text << "finite";
    if (std::isfinite(min)) text << (above_min ? ", above " : ", at least ") << min;
    if (std::isfinite(max)) text << ", at most " << max;
  }
  text << ".";
  return text.str();
}

OutputValues::OutputValues(const std::vector<Port>& ports) {
  int count = 0;
  for (const Port& p : ports) {
    if (p.output) count = std::max(count, p.group + p.component + 1);
  }
  values_.resize(count);
  known_.resize(count);
}

double OutputValues::operator()(const Port& p, const View& view) {
  double* values = values_.data() + p.group;
  if (!known_[p.group]) {
    p.output(view, p.object, p.port, values);
    known_[p.group] = 1;
  }
  return values[p.component];
}

void OutputValues::forget() { std::fill(known_.begin(), known_.end(), char{0}); }

// --- telling them ----------------------------------------------------------------------------------------------------

namespace {

// Calls make(index, suffix) for a vector's elements; a scalar has no suffix.
template <typename Make>
void elements(int count, Make make) {
  if (count == 0) make(0, "");
  for (int i = 0; i < count; ++i) make(i, "[" + std::to_string(i + 1) + "]");
}

}  // namespace

std::string with_note(const std::string& text, const std::string& note) {
  return note.empty() ? text : text + ": " + note;
}

void Ports::owner(const std::string& name, const std::string& kind, const std::string& type) {
  const auto same = [&](const Owner& owner) { return owner.name == name; };
  const auto found = std::find_if(owners_.begin(), owners_.end(), same);
  owner_ = static_cast<int>(found - owners_.begin());
  if (found == owners_.end()) owners_.push_back({name, kind, type, ""});
}

Port& Ports::add(std::string name, const char* type, std::string description) {
  Port p;
  p.name = std::move(name);
  p.description = std::move(description);
  p.owner = owner_;
  if (type) {
    p.type = &real_type(type);
    p.unit = p.type->unit;
    p.min = p.type->min;
    p.max = p.type->max;
  }
  ports_.push_back(std::move(p));
  return ports_.back();
}

Ports::Group Ports::group(int object, int size, Output compute, bool needs_accelerations, int port) {
  output_count_ += size;
  return {object, port, compute, needs_accelerations, output_count_ - size};
}

Port& Ports::output(const Group& group, int component, const std::string& name, const char* type,
                    const std::string& description) {
  Port& p = add(name, type, description);
  p.object = group.object;
  p.port = group.port;
  p.output = group.compute;
  p.needs_accelerations = group.needs_accelerations;
  p.group = group.start;
  p.component = component;
  return p;
}

void Ports::outputs(const Group& group, int first, const std::string& name, int count, const char* type,
                    const std::string& description, Rate rate) {
  elements(count, [&](int i, const std::string& suffix) {
    output(group, first + i, name + suffix, type, description).rate = rate;
  });
}

void Ports::outputs(int object, const std::string& name, int count, const char* type, const std::string& description,
                    Output compute, bool needs_accelerations) {
  outputs(group(object, std::max(1, count), compute, needs_accelerations), 0, name, count, type, description);
}

Port& Ports::output(int object, const std::string& name, const char* type, const std::string& description,
                    Output compute) {
  return output(group(object, 1, compute), 0, name, type, description);
}

Port& Ports::parameter(int object, const std::string& name, const char* type, const std::string& description,
                       Parameter access, Variability variability) {
  Port& p = add(name, type, description);
  p.causality = Causality::parameter;
  p.variability = variability;
  p.object = object;
  p.parameter = access;
  return p;
}

void Ports::parameters(int object, const std::string& name, int count, const char* type, const std::string& description,
                       Parameter access, Variability variability) {
  elements(count, [&](int i, const std::string& suffix) {
    parameter(object, name + suffix, type, description, access, variability).component = i;
  });
}

void Ports::initial(InitialValue what, const std::string& suffix, const char* type, const std::string& description) {
  Port& p =
      add(initial_name(mechanism.multibody, what) + suffix, type, description + "; stays if set, gives way if not");
  p.causality = Causality::parameter;
  p.variability = Variability::fixed;
  p.initial = what;
}

void Ports::initial_vector(InitialValue what, int count, const char* type, const std::string& description) {
  elements(count, [&](int i, const std::string& suffix) {
    what.component = i;
    initial(what, suffix, type, description);
  });
}

void Ports::input(int index, const std::string& name, const char* type, const std::string& description) {
  Port& p = add(name, type, description);
  p.causality = Causality::input;
  p.input = index;
}

void Ports::prescribed(int index, int derivative, const std::string& name, const char* type,
                       const std::string& description, double start) {
  Port& p = add(name, type, description);
  p.causality = Causality::input;
  p.prescribed = index;
  p.derivative = derivative;
  p.start = start;
}

void Ports::inputs(int first, const std::string& name, int count, const char* type, const std::string& description) {
  elements(count, [&](int i, const std::string& suffix) { input(first + i, name + suffix, type, description); });
}

void Ports::set_port(std::size_t first, int row) {
  for (std::size_t i = first; i < ports_.size(); ++i) ports_[i].port = row;
}

void Ports::set_times_velocity(std::size_t first) {
  for (std::size_t i = first; i < ports_.size(); ++i) ports_[i].times_velocity = true;
}

void Ports::terminal(const std::string& purpose, const std::vector<std::string>& members) {
  owners_[owner_].terminal = purpose;
  const std::string& owner = owners_[owner_].name;
  for (Port& p : ports_) {
    if (p.owner != owner_) continue;
    const std::string vector = p.name.substr(0, p.name.find('['));
    for (const std::string& member : members) p.in_terminal = p.in_terminal || vector == owner + "." + member;
  }
}

}  // namespace sigmafmu
