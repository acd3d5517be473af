#include "gap/locate/frames.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra.hpp"

namespace leeway::gap {
namespace {

struct FramePatterns {
  std::string name;
  std::vector<Pattern> patterns;
  bool is_of_place = false;
};

template <typename Value>
Pattern along(int axis, Value value) {
  return [axis, value](const Moment& m) -> Vec3<double> { return Vec3<double>::Unit(axis) * value(m); };
}

FramePatterns in_body() {
  FramePatterns frame{"body", {}};
  for (int axis = 0; axis < 3; ++axis) frame.patterns.push_back(along(axis, [](const Moment&) { return 1.0; }));
  return frame;
}

// A pull along x0 or y0, at a place of its own: surge, sway and the moment of the sway.
FramePatterns in_earth() {
  FramePatterns frame{"earth", {}};
  for (const bool is_east : {false, true}) {
    const auto surge = [is_east](const Moment& m) { return is_east ? std::sin(m.psi) : std::cos(m.psi); };
    const auto sway = [is_east](const Moment& m) { return is_east ? std::cos(m.psi) : -std::sin(m.psi); };
    frame.patterns.push_back([=](const Moment& m) { return Vec3<double>(surge(m), sway(m), 0.0); });
    frame.patterns.push_back(along(2, sway));
  }
  return frame;
}

FramePatterns in_apparent_wind() {
  const auto q = [](const Moment& m) { return m.apparent.norm(); };
  return {"apparent-wind",
          {along(0, [=](const Moment& m) { return q(m) * m.apparent(0); }),
           along(1, [=](const Moment& m) { return q(m) * m.apparent(1); }),
           along(2, [=](const Moment& m) { return q(m) * m.apparent(1); }),
           along(2, [](const Moment& m) { return m.apparent(0) * m.apparent(1); })}};
}

FramePatterns by_water_speed() {
  return {"water-speed",
          {along(0, [](const Moment& m) { return m.u * std::abs(m.u); }),
           along(0, [](const Moment& m) { return m.v * m.r; }), along(1, [](const Moment& m) { return m.v * m.U; }),
           along(1, [](const Moment& m) { return m.u * m.r; }), along(2, [](const Moment& m) { return m.v * m.u; }),
           along(2, [](const Moment& m) { return m.r * m.U; })}};
}

FramePatterns by_position() {
  FramePatterns frame{"position", {}, true};
  for (int axis = 0; axis < 3; ++axis) {
    frame.patterns.push_back(along(axis, [](const Moment& m) { return m.x0; }));
    frame.patterns.push_back(along(axis, [](const Moment& m) { return m.y0; }));
  }
  return frame;
}

FramePatterns by_actuator(const Ship& ship) {
  FramePatterns frame{"actuator", {}};
  for (const Actuator& actuator : ship.actuators) {
    const Channel c = actuator.channel;
    if (actuator.is_rudder()) {
      for (int axis = 0; axis < 3; ++axis)
        frame.patterns.push_back(along(axis, [c, axis](const Moment& m) {
          const double delta = m.actuators[c];
          return m.actuators[Channel::n_p] * m.actuators[Channel::n_p] *
                 (axis == 0 ? std::sin(delta) * std::sin(delta) : std::sin(delta) * std::cos(delta));
        }));
    } else if (!actuator.is_angle()) {
      const bool is_propeller = actuator.is_propulsion();
      for (int axis = is_propeller ? 0 : 1; axis < 3; ++axis)
        frame.patterns.push_back(
            along(axis, [c](const Moment& m) { return m.actuators[c] * std::abs(m.actuators[c]); }));
    }
  }
  return frame;
}

std::vector<FramePatterns> frames_for(const Campaign& campaign) {
  std::vector<FramePatterns> frames{in_body()};
  if (campaign.has_heading) frames.push_back(in_earth());
  if (campaign.has_wind) frames.push_back(in_apparent_wind());
  frames.push_back(by_water_speed());
  if (campaign.has_position) frames.push_back(by_position());
  frames.push_back(by_actuator(campaign.ship));
  return frames;
}

}  // namespace

std::vector<Frame> frames_of(const Campaign& campaign, const FittedNull& fit,
                             const std::vector<Eigen::Matrix3Xd>& residual, std::size_t jobs) {
  const std::vector<FramePatterns> tried = frames_for(campaign);
  std::vector<Pattern> patterns;
  for (const FramePatterns& frame : tried)
    patterns.insert(patterns.end(), frame.patterns.begin(), frame.patterns.end());
  const PatternEvidence evidence = pattern_evidence(campaign, fit, patterns, jobs);
  std::vector<Frame> frames;
  Eigen::Index first = 0;
  for (const FramePatterns& frame : tried) {
    const auto count = static_cast<Eigen::Index>(frame.patterns.size());
    const Eigen::VectorXd b = evidence.projected.b.segment(first, count);
    Eigen::MatrixXd M = evidence.projected.F.block(first, first, count, count);
    M.diagonal().array() += 1.0;  // strengths ~ N(0, reference acceleration^2)
    const Eigen::LLT<Eigen::MatrixXd> factor(M);
    frames.push_back({frame.name, 0.5 * b.dot(factor.solve(b)) - factor.matrixLLT().diagonal().array().log().sum(),
                      share_of(evidence, residual, first, count, -1), frame.is_of_place});
    first += count;
  }
  std::sort(frames.begin(), frames.end(),
            [](const Frame& a, const Frame& b) { return a.log_evidence > b.log_evidence; });
  return frames;
}

}  // namespace leeway::gap
