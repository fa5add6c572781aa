#include "model/json.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "model/json_tables.h"
#include "model/json_values.h"

namespace sigmafmu {
namespace json {
namespace {

constexpr const char* kGroundName = "ground";

template <typename... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
  fail<std::runtime_error>(parts...);
}

std::string joined(const std::string& path, const std::string& key) { return path.empty() ? key : path + "." + key; }

// The name that a value which is held has in the FMU.
std::string held_name(const MultibodyDef& d, const InitialValue& what) {
  return initial_name(d, what) + (what.of_joint() ? "" : "[" + std::to_string(what.component + 1) + "]");
}

template <typename Def, typename = void>
struct HasType : std::false_type {};
template <typename Def>
struct HasType<Def, std::void_t<decltype(Def::kType)>> : std::bool_constant<Def::kType != nullptr> {};

// Of the list of forces under a key.
std::vector<std::string> types_in_list(const std::string& list) {
  std::vector<std::string> words;
  const MultibodyDef none;
  for_each_force_list(none, [&](const char* key, const auto& forces) {
    using Def = typename std::decay_t<decltype(forces)>::value_type;
    if constexpr (HasType<Def>::value) {
      if (key == list) words.emplace_back(Def::kType);
    }
  });
  return words;
}

class Writer {
 public:
  Writer(std::string path, const MultibodyDef& multibody) : path_(std::move(path)), multibody_(multibody) {}

  template <typename T>
  void required(const std::string& key, const T& x) {
    object_[key] = value(x, joined(path_, key));
  }
  template <typename T>
  void optional(const std::string& key, const T& x, bool is_set = true) {
    if (is_set) required(key, x);
  }
  template <typename T>
  void choice(const std::string& key, const T& x, const std::vector<std::string>& words, int first) {
    const int i = static_cast<int>(x) - first;
    if (i < 0 || i >= static_cast<int>(words.size()))
      refuse(joined(path_, key), " is ", i + first, ", which has no name.");
    object_[key] = words[static_cast<std::size_t>(i)];
  }
  template <typename T>
  void optional_choice(const std::string& key, const T& x, const std::vector<std::string>& words, int first) {
    choice(key, x, words, first);
  }
  template <typename T, typename Add>
  void list(const std::string& key, const std::vector<T>& xs, const Add&) {
    Json& all = object_[key];
    if (all.is_null()) all = Json::array();
    for (const T& x : xs) all.push_back(value(x, at(joined(path_, key), all.size())));
  }
  template <typename Def>
  void parameters(const Def& d) {
    for (const Parameter<Def>& p : Def::parameters()) {
      const double* x = p.values(const_cast<Def&>(d));  // the accessors serve reading and writing
      const std::string key = key_of(p.name);
      if (p.size == 0) {
        required(key, *x);
      } else {
        required(key, std::vector<double>(x, x + p.size));
      }
    }
  }
  void joint(const std::string& key, int j) {
    if (j < 0 || j >= static_cast<int>(multibody_.joints.size())) {
      refuse(joined(path_, key), " is joint ", j, "; the mechanism has no such joint.");
    }
    object_[key] = multibody_.joints[j].name;
  }
  void version(const std::string& key, int number) { object_[key] = number; }
  void body(const std::string& key, int i) { object_[key] = body_name(i, joined(path_, key)); }
  void optional_body(const std::string& key, int i) { body(key, i); }
  void bodies(const std::string& key, int i, int j) {
    const std::string name = joined(path_, key);
    object_[key] = Json::array({body_name(i, at(name, 0)), body_name(j, at(name, 1))});
  }
  void held(const std::string& key, const MultibodyDef& d) {
    for (const auto& [what, x] : d.held) object_[key][held_name(d, what)] = std::isnan(x) ? Json() : Json(x);
  }
  Json&& take() { return std::move(object_); }

 private:
  Json value(double x, const std::string& name) const {
    if (!std::isfinite(x)) refuse(name, " is ", x, "; it must be finite.");
    return x;
  }
  Json value(int x, const std::string&) const { return x; }
  Json value(bool x, const std::string&) const { return x; }
  Json value(const std::string& x, const std::string&) const { return x; }
  Json value(const std::optional<ModalDef>& x, const std::string& name) const {
    if (x->file.empty()) refuse(name, " has modal data of no file; they must be in one.");
    return value(*x, name);
  }
  template <typename T>
  Json value(const std::optional<T>& x, const std::string& name) const {
    return value(*x, name);
  }
  template <int size>
  Json value(const Eigen::Matrix<double, size, size>& x, const std::string& name) const {
    Json rows = Json::array();
    for (int i = 0; i < size; ++i) {
      rows.push_back(value(Eigen::Matrix<double, size, 1>(x.row(i)), at(name, static_cast<std::size_t>(i))));
    }
    return rows;
  }
  template <int size>
  Json value(const Eigen::Matrix<double, size, 1>& x, const std::string& name) const {
    Json list = Json::array();
    for (Eigen::Index i = 0; i < x.size(); ++i) list.push_back(value(x[i], at(name, static_cast<std::size_t>(i))));
    return list;
  }
  template <typename T>
  Json value(const std::vector<T>& xs, const std::string& name) const {
    Json list = Json::array();
    for (std::size_t i = 0; i < xs.size(); ++i) list.push_back(value(xs[i], at(name, i)));
    return list;
  }
  template <typename T>
  Json value(const T& x, const std::string& name) const {
    Writer inner(name, multibody_);
    visit(inner, x);
    return inner.take();
  }
  std::string body_name(int i, const std::string& name) const {
    if (i == kGround) return kGroundName;
    if (i >= 0 && i < static_cast<int>(multibody_.bodies.size())) return multibody_.bodies[i].name;
    refuse(name, " is body ", i, "; the mechanism has no such body.");
  }

  const std::string path_;
  const MultibodyDef& multibody_;
  Json object_ = Json::object();
};

class Reader {
 public:
  // By their names, read so far.
  struct Known {
    std::map<std::string, int> bodies, joints;
  };
  Reader(const Json& object, std::string path, Known& known_elements)
      : object_(object), path_(std::move(path)), elements_(known_elements) {
    if (!object.is_object()) {
      refuse(path_.empty() ? "The mechanism" : path_, " is ", excerpt(object), "; it must be an object.");
    }
  }

  // x may be a Group, which is made in place.
  template <typename T>
  void required(const std::string& key, T&& x) {  // NOLINT(cppcoreguidelines-missing-std-forward)
    read(*find_required(key), joined(path_, key), x);
  }
  template <typename T>
  void optional(const std::string& key, T&& x, bool = true) {  // NOLINT(cppcoreguidelines-missing-std-forward)
    if (const Json* found = find(key)) read(*found, joined(path_, key), x);
  }
  template <typename T>
  void choice(const std::string& key, T& x, const std::vector<std::string>& words, int first) {
    find_required(key);
    optional_choice(key, x, words, first);
  }
  template <typename T>
  void optional_choice(const std::string& key, T& x, const std::vector<std::string>& words, int first) {
    const Json* found = find(key);
    if (!found) return;
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (*found == words[i]) return void(x = static_cast<T>(static_cast<int>(i) + first));
    }
    std::string allowed;
    for (std::size_t i = 0; i < words.size(); ++i) {
      allowed += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
    }
    refuse(joined(path_, key), " is ", excerpt(*found), "; it must be ", allowed, ".");
  }
  // Of a list that holds several types, those of this one.
  template <typename T, typename Add>
  void list(const std::string& key, const std::vector<T>&, const Add& add) {
    const Json* found = find(key);
    if (!found) return;
    const std::string name = joined(path_, key);
    json::list(*found, name, found->size());
    const std::vector<std::string> types = types_in_list(key);
    for (std::size_t i = 0; i < found->size(); ++i) {
      const Json& entry = (*found)[i];
      if constexpr (HasType<T>::value) {
        int type = 0;
        Reader(entry, at(name, i), elements_).choice("type", type, types, 0);
        if (types[static_cast<std::size_t>(type)] != T::kType) continue;
      }
      T x;
      read(entry, at(name, i), x);
      if constexpr (std::is_same_v<T, RigidBodyDef>) note(x.name, elements_.bodies);
      if constexpr (std::is_same_v<T, JointDef>) note(x.name, elements_.joints);
      add(std::move(x));
    }
  }
  void version(const std::string& key, int number) {
    const Json* found = find_required(key);
    if (*found != number) refuse(joined(path_, key), " is ", excerpt(*found), "; it must be ", number, ".");
  }
  template <typename Def>
  void parameters(Def& d) {
    for (const Parameter<Def>& p : Def::parameters()) {
      const std::string key = key_of(p.name);
      const Json* found = find(key);
      if (!found) continue;
      const std::string name = joined(path_, key);
      if (p.size > 0) json::list(*found, name, static_cast<std::size_t>(p.size));
      for (int i = 0; i < std::max(1, p.size); ++i) {
        const auto k = static_cast<std::size_t>(i);
        p.values(d)[i] = p.size == 0 ? number(*found, name) : number((*found)[k], at(name, k));
      }
    }
  }
  void joint(const std::string& key, int& j) {
    const Json& value = *find_required(key);
    std::string word;
    read(value, joined(path_, key), word);
    const auto found = elements_.joints.find(word);
    if (found == elements_.joints.end()) {
      refuse(joined(path_, key), " is ", excerpt(value), "; it must be the name of a joint.");
    }
    j = found->second;
  }
  void body(const std::string& key, int& i) { read_body(*find_required(key), joined(path_, key), i); }
  void optional_body(const std::string& key, int& i) {
    if (const Json* found = find(key)) read_body(*found, joined(path_, key), i);
  }
  void bodies(const std::string& key, int& i, int& j) {
    const std::string name = joined(path_, key);
    const Json& pair = json::list(*find_required(key), name, 2);
    read_body(pair[0], at(name, 0), i), read_body(pair[1], at(name, 1), j);
  }
  void held(const std::string& key, MultibodyDef& d) {
    const Json* found = find(key);
    if (!found) return;
    if (!found->is_object()) refuse(joined(path_, key), " is ", excerpt(*found), "; it must be an object.");
    const auto known = initial_values(d);
    for (const auto& [name, x] : found->items()) {
      const auto what = known.find(name);
      if (what == known.end())
        refuse(joined(path_, key), " has ", name, ", which is no initial value of the mechanism.");
      d.held[what->second] =
          x.is_null() ? std::numeric_limits<double>::quiet_NaN() : number(x, joined(joined(path_, key), name));
    }
  }
  // Refuses keys that nothing has asked for.
  void finish() const {
    for (const auto& item : object_.items()) {
      if (std::find(known_.begin(), known_.end(), item.key()) != known_.end()) continue;
      std::string allowed;
      for (const std::string& key : known_) allowed += (allowed.empty() ? "" : ", ") + key;
      refuse(joined(path_, item.key()), " is unknown; the keys here are ", allowed, ".");
    }
  }

 private:
  static void note(const std::string& name, std::map<std::string, int>& known) {
    known.emplace(name, static_cast<int>(known.size()));
  }
  const Json* find(const std::string& key) {
    if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.push_back(key);
    const auto found = object_.find(key);
    return found == object_.end() ? nullptr : &*found;
  }
  const Json* find_required(const std::string& key) {
    const Json* found = find(key);
    if (!found) refuse(joined(path_, key), " is missing.");
    return found;
  }
  static void read(const Json& value, const std::string& name, double& x) { x = number(value, name); }
  static void read(const Json& value, const std::string& name, bool& x) {
    if (!value.is_boolean()) refuse(name, " is ", excerpt(value), "; it must be true or false.");
    x = value.get<bool>();
  }
  static void read(const Json& value, const std::string& name, int& x) {
    if (value.is_number_integer()) {
      const double whole = value.get<double>();  // what is too large for an int remains too large
      if (std::abs(whole) <= std::numeric_limits<int>::max()) return void(x = static_cast<int>(whole));
    }
    refuse(name, " is ", excerpt(value), "; it must be a whole number.");
  }
  static void read(const Json& value, const std::string& name, std::string& x) {
    if (!value.is_string()) refuse(name, " is ", excerpt(value), "; it must be a text.");
    x = value.get<std::string>();
  }
  template <typename T>
  void read(const Json& value, const std::string& name, std::optional<T>& x) {
    read(value, name, x.emplace());
  }
  template <int size>
  void read(const Json& value, const std::string& name, Eigen::Matrix<double, size, size>& x) {
    json::list(value, name, size);
    for (int i = 0; i < size; ++i) {
      Eigen::Matrix<double, size, 1> row;
      read(value[static_cast<std::size_t>(i)], at(name, static_cast<std::size_t>(i)), row);
      x.row(i) = row;
    }
  }
  template <int size>
  void read(const Json& value, const std::string& name, Eigen::Matrix<double, size, 1>& x) {
    json::list(value, name, size == Eigen::Dynamic ? value.size() : static_cast<std::size_t>(size));
    x.resize(static_cast<Eigen::Index>(value.size()));
    for (std::size_t i = 0; i < value.size(); ++i) read(value[i], at(name, i), x[static_cast<Eigen::Index>(i)]);
  }
  template <typename T>
  void read(const Json& value, const std::string& name, std::vector<T>& xs) {
    json::list(value, name, value.size());
    for (std::size_t i = 0; i < value.size(); ++i) read(value[i], at(name, i), xs.emplace_back());
  }
  template <typename T>
  void read(const Json& value, const std::string& name, T& x) {
    Reader inner(value, name, elements_);
    visit(inner, x);
    inner.finish();
  }
  void read_body(const Json& value, const std::string& name, int& i) const {
    std::string word;
    read(value, name, word);
    const auto found = elements_.bodies.find(word);
    if (found != elements_.bodies.end()) return void(i = found->second);
    if (word != kGroundName) refuse(name, " is ", excerpt(value), "; it must be the name of a body or ground.");
    i = kGround;
  }
  // All that the mechanism has, by their names in the FMU.
  static std::map<std::string, InitialValue> initial_values(const MultibodyDef& d) {
    std::map<std::string, InitialValue> result;
    for (int kind = 0; kind <= static_cast<int>(InitialValue::Kind::joint_rate); ++kind) {
      InitialValue what{static_cast<InitialValue::Kind>(kind)};
      const std::size_t objects = what.of_joint() ? d.joints.size() : d.bodies.size();
      for (; what.object < static_cast<int>(objects); ++what.object) {
        const int components = component_count(d, what);
        for (what.component = 0; what.component < components; ++what.component) result[held_name(d, what)] = what;
      }
    }
    return result;
  }

  const Json& object_;
  const std::string path_;
  Known& elements_;
  std::vector<std::string> known_;
};

// Lists of numbers and texts on one line, all else indented.
void print(const Json& value, const std::string& indent, std::string& out) {
  const bool flat =
      value.is_array() && std::none_of(value.begin(), value.end(), [](const Json& x) { return x.is_structured(); });
  if (!value.is_structured() || value.empty()) {
    out += value.dump();
    return;
  }
  const std::string inner = indent + "  ";
  const char* separator = "";
  out += value.is_object() ? "{" : "[";
  for (const auto& item : value.items()) {
    out += separator;
    if (!flat) out += "\n" + inner;
    if (value.is_object()) out += Json(item.key()).dump() + ": ";
    print(item.value(), inner, out);
    separator = flat ? ", " : ",";
  }
  if (!flat) out += "\n" + indent;
  out += value.is_object() ? "}" : "]";
}

}  // namespace
}  // namespace json

std::string to_json(const Mechanism& mechanism) try {
  json::Writer writer("", mechanism.multibody);
  json::visit(writer, mechanism);
  std::string text;
  json::print(writer.take(), "", text);
  return text + "\n";
} catch (const json::Json::exception& e) {
  fail<std::invalid_argument>("The texts of the mechanism must be UTF-8: ", e.what(), ".");
} catch (const std::runtime_error& e) {
  fail<std::invalid_argument>(e.what());
}

Mechanism from_json(const std::string& text) try {
  Mechanism mechanism;
  json::Reader::Known elements;
  const json::Json content = json::parse_json(text, "The mechanism is no JSON: ");
  json::Reader reader(content, "", elements);
  json::visit(reader, mechanism);
  reader.finish();
  return mechanism;
} catch (const std::runtime_error& e) {
  fail<std::invalid_argument>(e.what());
}

std::map<std::string, std::string> texts_from_json(const std::string& text) try {
  const json::Json content = json::parse_json(text, "It is no JSON: ");
  if (!content.is_object()) fail<std::runtime_error>("It is ", json::excerpt(content), "; it must be an object.");
  std::map<std::string, std::string> texts;
  for (const auto& [key, value] : content.items()) {
    if (!value.is_string()) fail<std::runtime_error>(key, " is ", json::excerpt(value), "; it must be a text.");
    texts[key] = value.get<std::string>();
  }
  return texts;
} catch (const std::runtime_error& e) {
  fail<std::invalid_argument>(e.what());
}

}  // namespace sigmafmu
