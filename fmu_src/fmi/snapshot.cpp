#include "fmi/snapshot.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <type_traits>

#include "text/checksum.h"

namespace sigmafmu {
namespace {

constexpr char kMagic[8] = {'S', 'I', 'G', 'M', 'A', 'F', 'M', 'U'};
constexpr std::uint32_t kFormat = 6;

// The one list of what a snapshot consists of; `archive` writes or reads each item.
template <typename Archive, typename AnySnapshot>
void visit(Archive& archive, AnySnapshot& s) {
  archive(s.phase), archive(s.start_time), archive(s.stop_time), archive(s.has_stop_time), archive(s.tolerance);
  archive(s.stale);
  archive(s.parameters);
  for (auto& d : s.input.derivative) archive(d);
  for (auto& d : s.input.drive) archive(d);
  archive(s.input.start), archive(s.last_input.time);
  archive(s.last_input.u), archive(s.last_input.x), archive(s.last_input.xdot), archive(s.last_input.xddot),
      archive(s.last_input.turned);
  archive(s.parameter_jump), archive(s.vdot_before_jump);
  auto& x = s.state;
  archive(x.time), archive(x.elapsed), archive(x.q), archive(x.v), archive(x.vdot), archive(x.a), archive(x.lambda),
      archive(x.turned);
  archive(x.last_step), archive(x.counters), archive(x.mean_velocity), archive(x.mean_acceleration);
  archive(x.next_step), archive(x.error), archive(x.largest_error);
  archive(x.jacobian.values), archive(x.jacobian.pivots), archive(x.jacobian_step);
}

class Writer {
 public:
  template <typename T, std::enable_if_t<std::is_trivially_copyable_v<T>, int> = 0>
  void operator()(const T& value) {
    raw(&value, sizeof value);
  }
  template <typename T>
  void operator()(const std::vector<T>& values) {
    array(values.data(), values.size());
  }
  void operator()(bool value) { (*this)(static_cast<std::uint8_t>(value)); }
  void operator()(Phase value) { (*this)(static_cast<std::uint8_t>(value)); }
  void operator()(const Eigen::VectorXd& values) { array(values.data(), static_cast<std::size_t>(values.size())); }
  void raw(const void* data, std::size_t size) {
    if (size == 0) return;
    const char* begin = static_cast<const char*>(data);
    bytes.insert(bytes.end(), begin, begin + size);
  }
  std::vector<char> bytes;

 private:
  template <typename T>
  void array(const T* data, std::size_t count) {
    (*this)(static_cast<std::uint64_t>(count));
    raw(data, count * sizeof(T));
  }
};

class Reader {
 public:
  Reader(const char* begin, const char* end) : at_(begin), end_(end) {}

  template <typename T, std::enable_if_t<std::is_trivially_copyable_v<T>, int> = 0>
  void operator()(T& value) {
    raw(&value, sizeof value);
  }
  // Their types have fewer values than their bytes.
  void operator()(bool& value) { value = small_number(1) != 0; }
  void operator()(Phase& value) { value = static_cast<Phase>(small_number(static_cast<int>(Phase::terminated))); }
  template <typename T>
  void operator()(std::vector<T>& values) {
    values.resize(count(sizeof(T)));
    raw(values.data(), values.size() * sizeof(T));
  }
  void operator()(Eigen::VectorXd& values) {
    values.resize(static_cast<Eigen::Index>(count(sizeof(double))));
    raw(values.data(), static_cast<std::size_t>(values.size()) * sizeof(double));
  }
  void raw(void* data, std::size_t size) {
    if (size > left()) throw std::invalid_argument("The serialized FMU state is truncated.");
    if (size > 0) std::memcpy(data, at_, size);
    at_ += size;
  }
  std::size_t left() const { return static_cast<std::size_t>(end_ - at_); }

 private:
  int small_number(int largest) {
    std::uint8_t n = 0;
    (*this)(n);
    if (n > largest) throw std::invalid_argument("The serialized FMU state is damaged.");
    return n;
  }
  std::size_t count(std::size_t item) {
    std::uint64_t n = 0;
    (*this)(n);
    if (n > left() / item) throw std::invalid_argument("The serialized FMU state is truncated.");
    return static_cast<std::size_t>(n);
  }
  const char* at_;
  const char* end_;
};

// Notes the sizes of the vectors.
class Sizes {
 public:
  template <typename T, std::enable_if_t<std::is_trivially_copyable_v<T>, int> = 0>
  void operator()(const T&) {}
  template <typename T>
  void operator()(const std::vector<T>& values) {
    sizes_.at(count_++) = values.size();
  }
  void operator()(const Eigen::VectorXd& values) { sizes_.at(count_++) = static_cast<std::size_t>(values.size()); }
  bool operator==(const Sizes& other) const { return sizes_ == other.sizes_; }

 private:
  std::array<std::size_t, 32> sizes_{};
  std::size_t count_ = 0;
};

}  // namespace

bool same_sizes(const Snapshot& a, const Snapshot& b) {
  Sizes of_a, of_b;
  visit(of_a, a);
  visit(of_b, b);
  return of_a == of_b;
}

std::vector<char> serialize(const Snapshot& snapshot, const std::string& identity) {
  Writer writer;
  writer.raw(kMagic, sizeof kMagic);
  writer(kFormat);
  writer(std::vector<char>(identity.begin(), identity.end()));
  visit(writer, snapshot);
  writer(checksum({writer.bytes.data(), writer.bytes.size()}));
  return std::move(writer.bytes);
}

Snapshot deserialize(const char* bytes, std::size_t size, const std::string& identity) {
  std::uint64_t sum = 0;
  if (size < sizeof kMagic + sizeof sum || std::memcmp(bytes, kMagic, sizeof kMagic) != 0) {
    throw std::invalid_argument("The bytes are no serialized FMU state of sigmafmu.");
  }
  std::memcpy(&sum, bytes + size - sizeof sum, sizeof sum);
  if (sum != checksum({bytes, size - sizeof sum})) {
    throw std::invalid_argument("The serialized FMU state is truncated or damaged: its checksum is wrong.");
  }
  Reader reader(bytes + sizeof kMagic, bytes + size - sizeof sum);
  std::uint32_t format = 0;
  std::vector<char> other;
  reader(format);
  reader(other);
  if (format != kFormat || std::string(other.begin(), other.end()) != identity) {
    throw std::invalid_argument("The serialized FMU state belongs to another FMU or another version of it.");
  }
  Snapshot snapshot;
  visit(reader, snapshot);
  return snapshot;
}

}  // namespace sigmafmu
