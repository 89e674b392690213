#include "robot/device/wire.hpp"

#include <cmath>
#include <limits>
#include <string_view>
#include <type_traits>
#include <utility>

namespace kantaro::robot::wire {
namespace {

constexpr std::size_t kLongestName = 32;
constexpr Byte kOutcomes = static_cast<Byte>(CommandOutcome::kRefused) + 1;

// One list of fields serves both: Writer appends what Reader takes off again.

class Writer {
 public:
  void operator()(const auto&... values) { (One(values), ...); }
  void Enum(const auto& value, Byte /*count*/) { bytes.push_back(static_cast<Byte>(value)); }
  template <typename Element, typename Each>
  void List(const std::vector<Element>& elements, std::size_t /*most*/, Each each) {
    bytes.push_back(static_cast<Byte>(elements.size()));
    for (const Element& element : elements) each(element);
  }
  void Text(const std::string& text) {
    const std::string_view shown = std::string_view(text).substr(0, kLongestName);
    bytes.push_back(static_cast<Byte>(shown.size()));
    bytes.insert(bytes.end(), shown.begin(), shown.end());
  }

  Bytes bytes;

 private:
  template <typename Integer>
  void One(const Integer& value) {
    static_assert(std::is_integral_v<Integer>);
    const auto bits = static_cast<std::make_unsigned_t<Integer>>(value);
    for (std::size_t i = 0; i < sizeof(Integer); ++i) bytes.push_back(Byte(bits >> (8 * i)));
  }
  void One(const bool& value) { bytes.push_back(value ? 1 : 0); }
};

class Reader {
 public:
  explicit Reader(std::span<const Byte> bytes) : rest_(bytes) {}

  void operator()(auto&... values) { (One(values), ...); }
  template <typename Value>
  void Enum(Value& value, Byte count) {
    const Byte byte = Next();
    good_ = good_ && byte < count;
    if (good_) value = static_cast<Value>(byte);
  }
  template <typename Element, typename Each>
  void List(std::vector<Element>& elements, std::size_t most, Each each) {
    const Byte count = Next();
    good_ = good_ && count <= most;
    if (!good_) return;
    elements.resize(count);
    for (Element& element : elements) each(element);
  }
  void Text(std::string& text) {
    const Byte size = Next();
    good_ = good_ && size <= kLongestName && size <= rest_.size();
    if (!good_) return;
    text.assign(rest_.begin(), rest_.begin() + size);
    rest_ = rest_.subspan(size);
  }
  [[nodiscard]] bool ReadAll() const { return good_ && rest_.empty(); }

 private:
  template <typename Integer>
  void One(Integer& value) {
    static_assert(std::is_integral_v<Integer>);
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < sizeof(Integer); ++i) bits |= std::uint64_t{Next()} << (8 * i);
    value = static_cast<Integer>(bits);
  }
  void One(bool& value) {
    const Byte byte = Next();
    value = byte == 1;
    good_ = good_ && byte <= 1;
  }
  Byte Next() {
    if (rest_.empty()) {
      good_ = false;
      return 0;
    }
    const Byte byte = rest_.front();
    rest_ = rest_.subspan(1);
    return byte;
  }

  std::span<const Byte> rest_;
  bool good_{true};
};

/// A message's fields in the order in which they travel.
template <typename Io, typename M>
void Fields(Io& io, M& m) {
  using T = std::remove_const_t<M>;
  if constexpr (std::is_base_of_v<Aged, T>) io(m.age_us);
  if constexpr (std::is_same_v<T, Open>) {
    io(m.session);
  } else if constexpr (std::is_same_v<T, Hello>) {
    io(m.session, m.lockstep, m.watchdog_ms, m.encoder_step_nrad, m.speed_limit_urad_s,
       m.mirror_counts);
    io.List(m.streams, kSensorCount, [&](auto& stream) {
      io.Enum(stream.sensor, kSensorCount);
      io(stream.period_us);
    });
    io.Text(m.robot);
  } else if constexpr (std::is_same_v<T, Encoders>) {
    for (auto& count : m.counts) io(count);
  } else if constexpr (std::is_same_v<T, Infrared>) {
    for (auto& value : m.values) io(value);
  } else if constexpr (std::is_same_v<T, Inertial>) {
    for (auto& value : m.angular_velocity_urad_s) io(value);
    for (auto& value : m.specific_force_um_s2) io(value);
  } else if constexpr (std::is_same_v<T, wire::Inclination>) {
    io(m.roll_urad, m.pitch_urad);
  } else if constexpr (std::is_same_v<T, Compass>) {
    io(m.heading_urad, m.disturbed);
  } else if constexpr (std::is_same_v<T, Battery>) {
    io(m.voltage_mV, m.current_mA, m.charge_ppm);
  } else if constexpr (std::is_same_v<T, Trigger>) {
    io.Enum(m.camera, static_cast<Byte>(Sensor::kStereoCameras) + 1);
    io(m.frame);
  } else if constexpr (std::is_same_v<T, Status>) {
    io(m.watchdog_tripped, m.stopped, m.motor_fault, m.corrupt, m.lost);
  } else if constexpr (std::is_same_v<T, Ack>) {
    io.Enum(m.type, 0xFF);
    io(m.sequence);
    io.Enum(m.outcome, kOutcomes);
  } else if constexpr (std::is_same_v<T, Pace>) {
    io(m.step, m.front_images, m.stereo_pairs);
  } else if constexpr (std::is_same_v<T, PaceAck>) {
    io(m.step);
  } else if constexpr (std::is_same_v<T, wire::Laser>) {
    io(m.revolution, m.first, m.of);
    io.List(m.samples, wire::Laser::kMostSamples,
            [&](auto& sample) { io(sample.mirror, sample.range); });
  } else if constexpr (std::is_same_v<T, wire::Command>) {
    io(m.left_urad_s, m.right_urad_s, m.lights);
  } else {
    static_assert(std::is_same_v<T, Stop>);
  }
}

/// The types of Message's alternatives, in their order.
constexpr std::array kTypes{Type::kOpen,     Type::kHello,       Type::kEncoders, Type::kInfrared,
                            Type::kInertial, Type::kInclination, Type::kCompass,  Type::kBattery,
                            Type::kTrigger,  Type::kStatus,      Type::kAck,      Type::kPace,
                            Type::kPaceAck,  Type::kLaser,       Type::kCommand,  Type::kStop};
static_assert(kTypes.size() == std::variant_size_v<Message>);

template <std::size_t... kIndices>
std::optional<Message> Empty(Byte type, std::index_sequence<kIndices...> /*all*/) {
  std::optional<Message> message;
  ((kTypes[kIndices] == static_cast<Type>(type)
        ? static_cast<void>(message.emplace(std::in_place_index<kIndices>))
        : static_cast<void>(0)),
   ...);
  return message;
}

}  // namespace

Type TypeOf(const Message& message) { return kTypes[message.index()]; }

Bytes Payload(const Message& message) {
  Writer writer;
  std::visit([&](const auto& m) { Fields(writer, m); }, message);
  return writer.bytes;
}

std::optional<Message> Parse(const Frame& frame) {
  std::optional<Message> message =
      Empty(frame.type, std::make_index_sequence<std::variant_size_v<Message>>());
  if (!message) return std::nullopt;
  Reader reader(frame.payload);
  std::visit([&](auto& m) { Fields(reader, m); }, *message);
  if (!reader.ReadAll()) return std::nullopt;
  return message;
}

template <typename Integer>
Integer Fixed(double value, double units) {
  constexpr auto kLow = static_cast<double>(std::numeric_limits<Integer>::min());
  constexpr auto kHigh = static_cast<double>(std::numeric_limits<Integer>::max());
  const double scaled = std::round(value * units);
  if (!(scaled >= kLow)) return std::numeric_limits<Integer>::min();
  return scaled >= kHigh ? std::numeric_limits<Integer>::max() : static_cast<Integer>(scaled);
}
template std::uint16_t Fixed<std::uint16_t>(double, double);
template std::uint32_t Fixed<std::uint32_t>(double, double);
template std::int32_t Fixed<std::int32_t>(double, double);

}  // namespace kantaro::robot::wire
