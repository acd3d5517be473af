#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace leeway::gap {

// clang-format off
/// Sensors: channel quality, conventions, audit.
struct SensorsPolicy {
  double huber = 2.0;  ///< [sd] from here on a residual counts linearly | origin: choice
  double huber_variance = 0.9205;  ///< [-] mean of min(z^2, huber^2) of a standard normal z | origin: theory
  double window_s = 10.0;  ///< [s] at 3 m: over which eta' - R nu and psi' - r are integrated | origin: choice
  double node_share = 0.05;  ///< [-] of a window: samples as near to its end make its mean there | origin: choice
  double samples_of_hole = 3.5;  ///< [samples] apart, and a hole is not read across | origin: choice
  double longest_hole_s = 1.0;  ///< [s] at 3 m: nor across a longer one | origin: choice
  double smallest_angle_rad = 0.2 * 0.017453292519943295;  ///< [rad] of a heading that is worth a word | origin: choice, 0.2 deg
  double smallest_lever_m = 0.05;  ///< [m] at 3 m: of a lever arm that is worth a word | origin: choice
  double smallest_share = 0.01;  ///< [-] of a factor, or of the usual speed or rate, that is worth a word | origin: choice
  double smallest_latency_s = 0.05;  ///< [s] at 3 m: of a latency that is worth a word | origin: choice
  double smallest_latency_samples = 0.1;  ///< [samples] the same by the sampling time | origin: choice
  double least_speed_mps = 1e-3;  ///< [m/s] at 3 m: floor of the usual speed | origin: choice, rounding
  double least_rate_radps = 1e-4;  ///< [rad/s] at 3 m: floor of the usual yaw rate | origin: choice, rounding
  std::array<double, 10> start_latencies{-0.9, -0.5, -0.2, 0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9};  ///< [-] of the longest latency, from which latencies are sought | origin: choice
  double limited_sd = 2.5;  ///< [sd] to which residuals are limited before they are correlated | origin: choice
  double shrinking_pairs = 10.0;  ///< [pairs] of no correlation that are added to those that were seen | origin: choice
  double least_rho = -0.45;  ///< [-] bound of a correlation of neighbors; a moving average has -0.5 at least | origin: theory
  double most_rho = 0.9;  ///< [-] bound of a correlation of neighbors | origin: choice
  double certain_p = 0.1;  ///< [-] of the rate of false alarms: a p-value below is certain, and asks less of what was left out | origin: choice
  double heldout_sd = 2.0;  ///< [sd] by which a fault must predict better what was left out | origin: choice, one-sided 2 %
  double heldout_sd_if_certain = 1.0;  ///< [sd] the same where the p-value is certain | origin: choice
  double better_nats = 2.0;  ///< [nats] by which another fault must be better to stand before a simpler one | origin: choice
  double least_track_noise_m = 1e-4;  ///< [m] at 3 m: residuals below are rounding and interpolation | origin: choice
  double least_heading_noise_rad = 1e-5;  ///< [rad] the same of headings | origin: choice
  std::size_t resamples = 400;  ///< [draws] of units, for standard errors | origin: choice, time
  double rate_noise = 0.1;  ///< [-] noise by what the ship turned in a window, above which r has no factor | origin: choice
  std::size_t sign_flips = 40000;  ///< [draws] of signs, for family-wise p-values | origin: choice, time
  std::size_t fewest_windows = 8;  ///< [windows] of a kind that can be checked | origin: choice
  std::size_t fewest_units = 4;  ///< [units] that are left out in turn | origin: choice
  std::size_t most_faults = 4;  ///< [faults] of one campaign | origin: choice
  std::size_t most_absorbed = 3;  ///< [faults] that are too small to matter, but stay in the model | origin: choice
  std::int64_t shortest_cubic = 12;  ///< [samples] at least that share a cubic | origin: choice
  std::int64_t longest_cubic = 40;  ///< [samples] at most that share a cubic | origin: choice
  double cubic_s = 3.0;  ///< [s] at 3 m: that a cubic covers, about | origin: choice
  std::size_t fewest_repeats = 6;  ///< [samples] of one value that count as frozen | origin: choice
  double shortest_frozen_s = 2.0;  ///< [s] at 3 m: and the time over which they last | origin: choice
  std::size_t fewest_suspect = 10;  ///< [samples] of one value of an actuator that otherwise changes | origin: choice
  std::size_t fewest_changes = 50;  ///< [samples] at which it has to change | origin: choice
  double most_unchanged = 0.02;  ///< [-] but for this share of them | origin: choice
  double visible_correlation = 0.25;  ///< [-] from sample to sample; below, noise counts as white | origin: choice
  double longest_correlation = 0.9;  ///< [-] above, it is the motion that remains | origin: choice
  double turned_rad = 0.3;  ///< [rad] that a heading turns while another channel is frozen | origin: choice
  double decisive_odds = 10.0;  ///< [nats] log-odds for a reading that is claimed | origin: choice
  double certain_sd = 3.0;  ///< [sd] by which the mean of its blocks must speak for it | origin: choice
  double kinematic_ratio = 2.0;  ///< [-] by which errors must shrink: kinematics know no parameters | origin: choice
  double force_ratio = 1.3;  ///< [-] the same of forces, which do | origin: choice
  double most_odds_per_block = 4.0;  ///< [nats] log-odds that one block may give | origin: choice
  double odds_per_reading = 6.0;  ///< [nats] log-odds against each reading that differs | origin: choice
  std::size_t fewest_blocks = 4;  ///< [blocks] for any claim | origin: choice
  double like_others = 2.0;  ///< [-] times the error of the others: what is left where one recording is read rightly | origin: choice
  double odd_one_odds = 6.0;  ///< [nats] of one recording where all others read as stated | origin: choice
  double odd_one_ratio = 1.5;  ///< [-] by which its errors must shrink | origin: choice
  double odds_against_plain = 5.0;  ///< [nats] log-odds against a plain error of the force | origin: choice
  double absent_ratio = 1.15;  ///< [-] by which errors must shrink against no force at all | origin: choice
  std::size_t most_force_readings = 4;  ///< [readings] that forces may contradict | origin: choice
  std::size_t most_in_pairs = 9;  ///< [readings] that are tried in pairs | origin: choice, time
  std::array<double, 4> plain_gains{0.0, 0.7, 1.0, 1.4};  ///< [-] errors of a force that count as plain errors of a parameter | origin: choice
  std::array<double, 6> plain_gains_of_rudders{0.0, 0.2, 0.4, 0.7, 1.0, 1.4};  ///< [-] the same of rudders, which may lose most of theirs; of wind, a fifth is knots | origin: choice
  double largest_force_error = 10.0;  ///< [typical changes] beyond, all is equally wrong | origin: choice
  std::size_t most_force_windows = 480;  ///< [windows] of short predictions | origin: choice, time
  std::size_t windows_per_block = 3;  ///< [windows] | origin: choice
  double differing = 0.5;  ///< [-] of the median error: from there on two readings differ in a window | origin: choice
  double force_horizon_s = 15.0;  ///< [s] at 3 m: length of a short prediction | origin: choice
  double force_node_share = 0.04;  ///< [-] of it: samples as near to a time make the state there | origin: choice
  std::int64_t force_steps = 60;  ///< [steps] of a short prediction | origin: choice
  std::int64_t force_looks = 3;  ///< [-] times at which it is compared | origin: choice
  double longest_latency_s = 5.0;  ///< [s] at 3 m: of a sensor | origin: choice
  std::size_t enough_recordings = 10;  ///< [recordings] from here on whole ones are left out in turn | origin: choice
  std::size_t blocks = 16;  ///< [blocks] of a few recordings that are left out in turn | origin: choice
  std::size_t fewest_for_resolution = 20;  ///< [samples] that show whether a channel is quantized | origin: choice
  double same_step = 0.05;  ///< [-] of a step: as near to a multiple of it | origin: choice, rounding
  double frozen_steps = 3.0;  ///< [steps] of a quantized channel that it should have moved | origin: choice
  double frozen_track = 0.05;  ///< [-] of the way through the water that a position should have moved | origin: choice
  double highest_phi = 0.98;  ///< [-] correlation of neighbors up to which noise is sought | origin: choice
  double recording_by_latency = 10.0;  ///< [-] duration of the longest recording by the longest latency that is sought in it | origin: choice
  double least_share_of_step = 0.05;  ///< [-] of a Gauss-Newton step: a shorter one is not tried | origin: choice
  double fit_converged = 1e-4;  ///< [nats] twice the gain of a step, below which a fit of faults has converged | origin: choice
  std::int64_t fit_steps = 12;  ///< [steps] of a fit of faults at most | origin: choice, time
  std::int64_t level_rounds = 30;  ///< [rounds] of Huber's level | origin: choice, it has converged long before
  std::size_t wind_samples = 400;  ///< [samples] of a recording in which true and apparent wind are compared | origin: choice, time
  std::size_t most_wind_blocks = 8;  ///< [blocks] of a recording for it | origin: choice
  std::size_t fewest_windows_of_block = 2;  ///< [windows] | origin: choice
  double one_point_s = 0.15;  ///< [s] at 3 m: sampling time below which one Gauss point integrates a step | origin: choice
  double two_points_s = 0.3;  ///< [s] at 3 m: below which two do, and above three | origin: choice
  double samples_of_window = 4.0;  ///< [samples] that a window lasts at least | origin: choice
  double node_samples = 0.51;  ///< [samples] to each side of a node at least, so that one lies within | origin: choice, half of one and rounding
  std::int64_t reconsidered_rounds = 3;  ///< [rounds] in which each chosen fault is compared with all others anew | origin: choice, time
  std::size_t fewest_for_noise = 4;  ///< [pieces] of a channel, for the correlation and the size of its noise | origin: choice
  std::int64_t bisections = 40;  ///< [steps] that halve the range of a correlation | origin: choice, far below rounding
  double erfc_until = 25.0;  ///< [-] argument beyond which a complementary error function underflows and its asymptote is taken | origin: theory, double precision
  double least_error = 1e-9;  ///< [-] floor of an error before its logarithm | origin: choice, rounding
  double least_turned_rad = 1e-6;  ///< [rad] floor of what a heading turns in a window, before dividing by it | origin: choice, rounding
  double least_change = 1e-6;  ///< [m/s, rad/s] at 3 m: floor of the typical change of a velocity, before dividing by it | origin: choice, rounding
  double difference_sd = 1e-2;  ///< [sd] of a fault's number, for derivatives | origin: choice
  double difference_prior_sd = 1e-4;  ///< [prior sd] of a fault's number, for derivatives | origin: choice
  double same_time_s = 1e-9;  ///< [s] by which times of one window may differ | origin: choice, rounding
  double within_step_s = 1e-6;  ///< [s] from the end of a step, so that a time lies within it | origin: choice, rounding
  double same_value = 1e-9;  ///< [-] of a channel's range: nearer values are one | origin: choice, rounding
  double least_sampling_s = 1e-3;  ///< [s] at 3 m: floor of the sampling time, before dividing by it | origin: choice, rounding
  double prior_heading_bias_deg = 20.0;  ///< [deg] prior sd of a heading's bias | origin: choice, wide
  double prior_lever_m = 30.0;  ///< [m] at 3 m: of a lever arm | origin: choice, wide
  double prior_scale = 0.3;  ///< [-] of a factor of speeds or of the yaw rate | origin: choice, wide
  double prior_log_bias_mps = 1.0;  ///< [m/s] at 3 m: of an offset of speeds | origin: choice, wide
  double prior_current_mps = 1.5;  ///< [m/s] at 3 m: of each component of a current | origin: choice, wide
  double prior_delay_s = 3.0;  ///< [s] at 3 m: of a latency, and of the lag of a filter | origin: choice, wide
  double prior_rate_bias_degps = 1.0;  ///< [deg/s] at 3 m: of a yaw rate's bias | origin: choice, wide
  double usual_heading_bias_deg = 1.0;  ///< [deg] sd of a heading's bias where there is one | origin: choice; of the others below as well
  double usual_lever_m = 0.2;  ///< [m] at 3 m: of a lever arm | origin: choice
  double usual_scale = 0.03;  ///< [-] of a factor of speeds or of the yaw rate | origin: choice
  double usual_log_bias_mps = 0.02;  ///< [m/s] at 3 m: of an offset of speeds | origin: choice
  double usual_delay_s = 0.5;  ///< [s] at 3 m: of a latency, and of the lag of a filter | origin: choice
  double usual_rate_bias_degps = 0.05;  ///< [deg/s] at 3 m: of a yaw rate's bias | origin: choice
};
// clang-format on

}  // namespace leeway::gap
