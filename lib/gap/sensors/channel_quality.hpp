#pragma once

#include <string>
#include <vector>

#include "gap/result/sensor_findings.hpp"
#include "gap/sensors/froude_scale.hpp"

namespace leeway::gap {

/// What the channels of a motion (u, v_m, r, x0, y0, psi) are like, over all recordings that have them. Times below are
/// those of a ship of 3 m.
///
/// Noise: what is left after fitting cubics to stretches of 3 s, or 12 samples where they take longer; its level and
/// the correlation from one sample to the next follow from the residuals' variance and lag-one covariance, both
/// corrected for what the fit takes away. A ship that turns much within a few samples adds to the noise: the stretches'
/// median keeps that small.
std::vector<ChannelQuality> channel_qualities(const std::vector<Trajectory>& recordings, const FroudeScale& scale);

/// The smallest step between different values where all are multiples of it; 0 for a channel that is not rounded.
double resolution(const std::vector<double>& values);

/// That a channel is frozen, and where.
std::string frozen_text(const ChannelQuality& quality);

/// Whether no channel of the motion ever changes.
bool is_at_rest(const Trajectory& recording);

/// Sentences on actuators that keep one value for ten samples or more, away from their ends, although they change from
/// sample to sample elsewhere, as a measured angle or rate does. A held order looks the same and is not suspected.
std::vector<std::string> suspect_actuators(const Trajectory& recording, const FroudeScale& scale);

/// The recording without the samples in which a channel repeats one value although the ship moves: six or more
/// over 2 s or more, while another channel says that it must have changed; for most of a recording, a ship that turned.
Trajectory without_frozen(const Trajectory& recording, const FroudeScale& scale);

}  // namespace leeway::gap
