#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "gap/policy/sensors_policy.hpp"

/// Every threshold of the gap tools, a line each: [unit], what it bounds, and where it comes from: theory, measured (on
/// which cases) or our choice. All members have eight bytes, so that the struct has no padding and its bytes can be
/// hashed.
namespace leeway::gap {

// clang-format off
/// Campaign and filter.
struct FilterPolicy {
  double longest_gap_s = 30.0;  ///< [s] at 3 m: a longer hole ends a stretch | origin: choice
  double hole_steps = 1.6;  ///< [steps] of the grid between two measurements: from there on a hole is filled with points without any | origin: choice, between one step and two
  double thinned_below = 0.75;  ///< [-] sampling time by the grid's: below, samples are averaged | origin: choice
  double thinning_worth_a_word = 1.5;  ///< [samples] of a mean, from which on the report says it | origin: choice
  double initial_position_L = 0.1;  ///< [L_pp] sd of the first position about the first measurements | origin: choice, wide
  double initial_heading_rad = 0.2;  ///< [rad] the same of the heading | origin: choice, wide
  double initial_froude = 0.05;  ///< [sqrt(g L)] the same of the velocities | origin: choice, wide
  double initial_rate_froude = 0.2;  ///< [sqrt(g/L)] the same of the yaw rate | origin: choice, wide
  double first_wind_share = 0.12;  ///< [-] sd of the wind's error by its mean speed, from which a fit begins | origin: choice
  double helm_difference = 0.005;  ///< [rad] of the rudders, for the slope of a step by their angle where a course is kept | origin: choice, rounding
  double timing_sd = 2.0;  ///< [tenths of the sampling time] sd of each step's own timing | origin: theory, a straight line between samples errs by up to a third of their distance
  double first_receiver_sd_mps = 0.005;  ///< [m/s] error that a receiver's velocity and way share, where its estimate begins | origin: choice
  double first_receiver_tau_s = 1.5;  ///< [s] its correlation time, of sensors and so the same at any scale | origin: choice
  double actuator_timing_sd = 0.3;  ///< [tenths of the sampling time] sd of how much later than recorded all actuators moved, unless the ship file states it | origin: theory, timings of single steps average over some forty moves; measured: -0.04 +- 0.25 and -0.11 +- 0.48 on four noisy maneuvers of each of two ships
  double heading_difference_rad = 0.01;  ///< [rad] for derivatives of networks | origin: choice
  std::size_t fewest_points = 20;  ///< [points] of a stretch: about two correlation times of the model error | origin: choice
  std::size_t most_points = 1500;  ///< [points] then a new stretch begins, so that threads share long recordings | origin: choice, time
  double independent = 2.0;  ///< [correlation times] of the noise after which a measurement counts anew | origin: theory, a first-order process
  double most_left_out = 10.0;  ///< [points] of the grid between two measurements | origin: choice
  std::int64_t averaged_parts = 8;  ///< [parts] of a step in which recorded inputs are averaged | origin: choice
  double coarsest_actuator_share = 0.02;  ///< [-] of an actuator's range: steps of recorded orders that are larger are no rounding | origin: choice, indicators show a degree of 70 or better
  double finest_actuator_share = 1e-3;  ///< [-] of it: smaller steps are not reckoned with | origin: choice, steps of 1 deg of 70 made p-values of 1e-17 in 2.5 hours of recordings, and what they do goes with their square
  double lost_actuator = 0.5;  ///< [ranges x steps] by which an actuator's bridging errs, times the hole's length: beyond, a stretch ends | origin: choice, half an actuator's range over one step of the grid
  double timing_share = 0.1;  ///< [-] of the sampling time: how well the motion of actuators between samples is known | origin: choice
  double paper_length_m = 3.0;  ///< [m] of the ship that the ensemble paper learns with time steps of 1 s | origin: the paper
  double slowest = 1.5;  ///< [-] sampling time by the time step of an ensemble: no longer holes are bridged | origin: choice
  double margin = 0.1;  ///< [-] of an input's range, as the networks beside a ship fade out | origin: choice
  double input_difference = 0.05;  ///< [-] of an input's sd, for derivatives of networks in single precision | origin: choice
  double tiny = 1e-14;  ///< [-] of a covariance: floor | origin: choice, rounding
  double instant_s = 1e-3;  ///< [s] over which a measured point counts as an instant | origin: choice
  double chord = 0.1;  ///< [-] of the speed and of coefficients: about how well they are known | origin: choice
  double switching_mps2 = 3e-5;  ///< [m/s^2] of an acceleration that a switch changes, from which on a step counts as one in which the model switches | origin: choice
  double tangent = 0.01;  ///< [-] of the chord | origin: choice
  double step_time_units = 2.0;  ///< [sqrt(L/g)] grid of the filter, unless asked for otherwise | origin: choice, a ship answers in several of them
  double grid_separability = 3.0;  ///< [-] d' up to which nobody tells by how much means over a step are off since actuators move within it | origin: choice, three standard deviations
  double finest_grid = 0.25;  ///< [-] of that grid, which is halved until this is so | origin: choice, time
  double same_bin = 1e-6;  ///< [steps] by which a sample may lie before its bin | origin: choice, rounding
  double same_substep = 1e-9;  ///< [substeps] by which a step may be longer | origin: choice, rounding
  double correlated_share = 0.75;  ///< [-] of the judged channels: with fewer correlated ones, none is thinned | origin: choice
  double nearly_a_step = 0.25;  ///< [steps] of the grid by which a distance may fall short of a whole number of them | origin: choice
  double origin_lengths = 100.0;  ///< [L_pp] to the nearest position: beyond, positions are counted from the first one | origin: measured, at 3 m 330 L change nothing and from 3300 L on forces that change with the place have no digits left
  std::size_t first_points = 5;  ///< [points] that the filter needs before its path is followed | origin: choice
};

/// Null fit and fits with effects.
struct FitPolicy {
  double scale_log_sd = 0.5;  ///< [ln] prior sd of the common scale of the coefficients' widths | origin: choice, a file's widths are right within a factor of about two
  std::size_t scales = 9;  ///< [values] of the common scale over which is averaged | origin: choice, rounding
  double slab_log_sd = 0.6;  ///< [ln] prior sd of a coefficient that is off by far more than stated | origin: choice, half to twice; that of effects that are factors
  double slab_odds = 0.06;  ///< [-] prior odds, shared by all coefficients, that each is off so far, against that it is not | origin: choice, those of one effect of the catalogue
  double most_slab_nats = 500.0;  ///< [nats] beyond which they are not told apart | origin: choice, rounding
  double scale_reach_sd = 3.0;  ///< [prior sd] that they cover to each side | origin: choice, rounding
  std::size_t path_neighbors = 2;  ///< [points] to each side, of which a path takes the median where the simulator runs away along the measurements | origin: choice, two that are far off beside each other move it not
  double outlier_sd = 6.0;  ///< [sd] of what the other measurements predict | origin: choice
  double least_left = 0.01;  ///< [-] of a measurement's variance that the smoothed state does not share | origin: choice, rounding
  double least_robust_sd = 0.5;  ///< [-] sd by which outliers are judged, by the one with them | origin: choice
  double theta_converged = 0.02;  ///< [prior sd] by which parameters may still move | origin: choice
  double theta_nearly_converged = 0.1;  ///< [prior sd] from there on noise levels are estimated anew | origin: choice, time
  double near_sd = 0.3;  ///< [posterior sd] distance from the best parameters of a converged fit | origin: choice
  double far_sd = 3.0;  ///< [posterior sd] the same where steps no longer help | origin: choice
  double noise_converged = 0.03;  ///< [ln] by which a noise level may still move | origin: choice
  double poor_step = 0.25;  ///< [-] gain by the expected one: below, the next step is shortened | origin: choice, usual for trust regions
  double good_step = 0.75;  ///< [-] above, the next one is longer | origin: choice, the same
  double level_gradient = 0.05;  ///< [-] slope of the cost in units of a level, at which its minimization ends: so many standard errors off | origin: choice
  double level_gain = 1e-9;  ///< [-] relative gain at which it ends | origin: choice, rounding
  double at_bound = 0.01;  ///< [-] nearer to a bound, a level counts as at it | origin: choice
  double least_level_curvature = 0.1;  ///< [1/ln^2] of the cost, for the standard error of a level | origin: choice, wide
  double most_level_curvature = 1e6;  ///< [1/ln^2] more than that a change of the slope is not taken for curvature: it is a bound | origin: choice, rounding
  std::size_t points_for_levels = 4000;  ///< [points] of a sample of stretches, by which levels are found | origin: choice, time
  double largest_step = 0.3;  ///< [ln] of a coefficient in one iteration | origin: choice
  double largest_timing_step = 3.0;  ///< [tenths of the sampling time] of the timing | origin: choice
  double largest_effect_step = 1.0;  ///< [prior sd] of an effect's coordinate | origin: choice
  double least_damping = 0.3;  ///< [-] by which 1 + damping shortens a step | origin: choice
  double most_damping = 20.0;  ///< [-] beyond, no step helps | origin: choice
  double damping_factor = 4.0;  ///< [-] from one damping to the next | origin: choice
  double least_gain = 0.01;  ///< [nats] of the log posterior by a step | origin: choice
  double measurable_gain = 0.1;  ///< [nats] of expected gain by which steps are judged | origin: choice
  double nearer = 0.8;  ///< [-] or so much nearer to where the slope vanishes | origin: choice
  double least_error = 0.005;  ///< [-] of the typical acceleration: steps, means and inputs are no better | origin: choice
  double event_block_s = 10.0;  ///< [s] at 3 m, times sqrt(L): blocks in which something may act | origin: choice
  double event = 16.0;  ///< [-] mean square of the model error in a block by the usual one: an event | origin: choice
  double still_event = 4.0;  ///< [-] the same of a block that was one | origin: choice
  double median_square = 0.6;  ///< [-] median of the mean square of about two independent values | origin: theory
  std::int64_t free_steps = 8;  ///< [iterations] in which steps need not make the recordings likelier | origin: choice
  std::int64_t events_fixed = 14;  ///< [iterations] after which events stay what they are | origin: choice
  double level_reach = 1.5;  ///< [ln] of a level: paths are renewed before one goes farther | origin: choice
  std::int64_t most_iterations = 30;  ///< [iterations] of a fit | origin: choice, time
  std::array<std::int64_t, 2> outliers_at{2, 6};  ///< [iterations] in which outliers are left out: at first, and once events no longer hide them | origin: choice
  std::size_t posterior_draws = 4000;  ///< [draws] for intervals of parameters that are no linear function of z | origin: choice, time
  double factor_log_sd = 0.6;  ///< [ln] least prior sd of a factor: stated coefficients have their own uncertainty already | origin: choice
  double least_factor = 0.02;  ///< [-] lower bound of a factor; the upper one is the catalogue's | origin: choice
  double least_own_variance = 1e-6;  ///< [-] of a coefficient's stated variance, that does not follow from the others | origin: choice, rounding
  double difference = 0.01;  ///< [prior sd] of a coordinate, for derivatives | origin: choice
  double direction_difference = 1e-4;  ///< [prior sd] the same of a direction | origin: choice
  double farthest = 8.0;  ///< [prior sd] beyond which a coordinate is not followed | origin: choice
  double first_sigma_w_mps2 = 1e-3;  ///< [m/s^2] model error from which a fit begins | origin: choice
  double first_tau_s = 12.0;  ///< [s] at 3 m, times sqrt(L): its correlation time there | origin: choice
  double least_tau_s = 4.0;  ///< [s] at 3 m: shorter is noise of the sensors | origin: choice
  double longest_tau_s = 40.0;  ///< [s] at 3 m: longer is a force that has a cause | origin: choice
  double less_error_with_receiver = 3.0;  ///< [-] by which the ship's model error is smaller where a receiver's is sought | origin: choice, a start
  std::int64_t receiver_steps = 20;  ///< [steps] of the levels until that is judged | origin: choice, time
  double wind_tau_s = 15.0;  ///< [s] at 3 m: correlation time of the wind's error | origin: choice
  double least_position_sd_m = 1e-3;  ///< [m] at 3 m, times L^(1/4): no sensor shows less | origin: choice
  double least_heading_sd_deg = 0.02;  ///< [deg] the same of headings | origin: choice
  double least_speed_sd_mps = 4e-4;  ///< [m/s] at 3 m, times sqrt(L): sampled inputs leave more | origin: choice
  double least_rate_sd_degps = 0.01;  ///< [deg/s] at 3 m, by sqrt(L) | origin: choice
  std::array<double, 6> least_first_sd{1e-3, 1e-3, 1e-4, 1e-4, 1e-4, 1e-5};  ///< [m, m, rad, m/s, m/s, rad/s] at 3 m: noise from which a fit begins at least | origin: choice
  double level_prior_sd = 3.0;  ///< [ln] of a noise level: within a factor of 20 | origin: choice
  double tau_prior_sd = 0.5;  ///< [ln] of the correlation time | origin: choice
  double wind_prior_sd = 1.0;  ///< [ln] of the wind's error | origin: choice
  double level_curvature_step = 0.2;  ///< [ln] of a noise level, for its standard error | origin: choice
};

/// Tests for effects, and the screen.
struct DetectPolicy {
  double reference_acceleration_mps2 = 5e-4;  ///< [m/s^2] an acceleration that is worth finding; the same at any scale (Froude) | origin: choice
  double gyration_radius_per_L = 0.25;  ///< [L_pp] where yaw accelerations are compared with those in surge and sway | origin: choice, the usual radius of gyration of ships
  double false_alarm = 0.01;  ///< [-] rate of a mismatch, of a fault and of an interval where there is none | origin: choice, the default of an option
  std::size_t refitted = 6;  ///< [effects] that are tested anew with the noise levels that fit them | origin: choice, time
  double least_information = 1.0;  ///< [-] d'^2 at nominal strength below which an effect is not excited | origin: choice
  double least_eigenvalue = 1e-3;  ///< [-] of the correlation matrix of an effect's columns, by their number: below, a direction is not determined | origin: choice
  double least_relative_information = 1e-12;  ///< [-] of the largest: floor before columns are scaled by it | origin: choice, rounding
  double block_s = 60.0;  ///< [s] at 3 m, times sqrt(L): blocks over which correlation and held-out gains are counted | origin: choice
  double least_step_s = 1e-9;  ///< [s] floor of the grid step before dividing by it | origin: choice, rounding
  std::size_t least_recordings = 4;  ///< [recordings] from here on whole recordings are left out in turn, below blocks | origin: choice
  std::size_t most_folds = 8;  ///< [folds] of blocks that are left out in turn | origin: choice, time
  std::size_t lags = 10;  ///< [points] lags of the autocorrelations in the test of whiteness | origin: choice, as is usual with Ljung & Box (1978)
  double least_innovations = 30.0;  ///< [points] of a channel, below which its whiteness is not tested | origin: choice
  double flat_prior_sd = 100.0;  ///< [nominal strengths] prior sd of an effect that is refitted | origin: choice, as good as flat
  std::int64_t level_iterations = 10;  ///< [iterations] of the noise levels of a refitted effect | origin: choice, time
  double level_step = 0.15;  ///< [ln] of a noise level, for differences of costs and of information | origin: choice
  double least_curvature = 0.5;  ///< [1/ln^2] of the cost by a noise level: floor | origin: choice
  double least_variance = 1e-9;  ///< [ln^2] of the information: floor before degrees of freedom are counted | origin: choice, rounding
  double least_dof = 4.0;  ///< [-] of the information about an effect: floor | origin: choice
  std::size_t score_draws = 20000;  ///< [draws] of scores where there is nothing, for the family-wise p-value | origin: choice, time
  double resolved_p_value = 1e-3;  ///< [-] the smallest p-value that the draws count; below, in proportion | origin: choice, from their number
  double most_log_strength = 0.3;  ///< [ln] of a log-normal strength from off to nominal | origin: choice
  double uniform_share = 0.3;  ///< [-] of the range of a uniform strength from off to nominal | origin: choice
  double angles_per_sample = 4.0;  ///< [-] points per recorded sample at which rudders' angles are compared | origin: choice
  double known_angle_deg = 0.5;  ///< [deg] root mean square by which rudders differ that is no different from none | origin: choice, the accuracy of measured angles
  double helm_ahead = 0.1;  ///< [-] of the variance of what rudders do beside following the ship: what the sensors leave unknown of her, from which on rudders tell more | origin: measured, 0.58 to 1.6 in 27 straight runs under an autopilot, 0.007 at most in 141 others (docs/gap-method.md)
  double still_sds = 3.0;  ///< [sd] rms sway and yaw rate of a straight run, by what the recordings leave unknown of them, up to which neither is told from none | origin: theory, 0.997 of a normal distribution
  double kept_actuator_share = 0.02;  ///< [-] of an actuator's range: width within which it is hardly used | origin: choice
  double tail_share = 0.1;  ///< [-] of the time that these widths leave out to each side | origin: choice
  double first_wind = 0.7;  ///< [prior sd] components of a wind's starts around the compass: in calm air forces have no slope | origin: choice
  std::array<double, 5> start_strengths{-2.0, -1.0, 0.0, 1.0, 2.0};  ///< [prior sd] of the starts of an effect without neutral value | origin: choice
  std::int64_t compass_starts = 8;  ///< [directions] of starts around the compass | origin: choice, time
  double shifted_sd = 2.0;  ///< [stated sd] of a coefficient beyond which an effect may have shifted it | origin: choice
  double longest_log_step = 1.0;  ///< [ln] of a coefficient, in the first linear step | origin: choice
  double longest_start = 3.0;  ///< [prior sd] of a coordinate of an effect, in the first linear step | origin: choice
};

/// Intervals, frames, regimes, modules.
struct LocatePolicy {
  std::size_t most_blocks = 250;  ///< [blocks] of all stretches, about: their matrices are dense | origin: choice, time
  double block_s = 10.0;  ///< [s] at 3 m, times sqrt(L): no block is shorter | origin: choice
  std::size_t least_points = 5;  ///< [points] of a block | origin: choice
  std::size_t active_blocks = 4;  ///< [blocks] after which the filter has forgotten an acceleration | origin: choice
  double gain_step = 0.1;  ///< [-] of a module's gain, for differences | origin: choice
  std::size_t scan_draws = 2000;  ///< [draws] of the largest statistic of the scan where there is nothing | origin: choice, time
  std::size_t tail_draws = 100;  ///< [draws] of these that reach the level beyond which p-values go on with the tail of one run | origin: choice
  std::size_t most_intervals = 8;  ///< [intervals] that are reported | origin: choice
  std::size_t most_untrained = 16;  ///< [intervals] in which an ensemble was not trained that are reported | origin: choice
  double mostly_outside = 0.5;  ///< [-] share of an interval's points beyond the training data: untrained | origin: choice
  double one_member_more = 1e-3;  ///< [-] probability of a further member that differs as much: untrained above | origin: choice
  double longest_share = 0.6;  ///< [-] of all blocks: longer is no interval | origin: choice
  double least_unexplained = 0.1;  ///< [-] of a run's variance that the parameters must leave | origin: choice
  double least_variance = 1e-6;  ///< [-] of the score of a run: below, the recordings say nothing about it | origin: choice, rounding
  double ridge = 1e-9;  ///< [-] of the largest or summed diagonal, added to a matrix before it is decomposed | origin: choice, rounding
  double least_ridge = 1e-300;  ///< [-] added to that where all is zero | origin: choice, rounding
  double small_share = 0.2;  ///< [-] of the typical acceleration of an axis: intervals below are called small | origin: choice, errors of the forms of forces
  double sway_share = 0.05;  ///< [-] of the residual's energy: with less there is no side force to speak of | origin: choice
  double group_taus = 4.0;  ///< [tau] length of the groups of blocks that are left out in turn for the line of action | origin: choice: longer than correlation
  std::size_t least_groups = 3;  ///< [groups] for an error of the line of action | origin: choice
  double most_line_sd = 0.2;  ///< [L_pp] sd beyond which a line of action is not known | origin: choice
  std::array<double, 6> walk_steps{0.01, 0.02, 0.04, 0.08, 0.16, 0.32};  ///< [-] sd per block of the walk of a module's gain that are tried | origin: choice, by factors of 2
  double least_gain_information = 1.0;  ///< [-] about a module's gain: below, the module is at rest | origin: choice
  double least_pattern_rms = 1e-9;  ///< [reference accelerations] of a pattern that is there | origin: choice, rounding
  double least_relative_spread = 1e-6;  ///< [-] of a variable, by its mean: below, it is constant | origin: choice, rounding
  double least_mean = 1e-3;  ///< [SI] added to that mean | origin: choice, rounding
  double least_froude = 0.02;  ///< [-] floor of the Froude number in r' = r L/U | origin: choice
  double most_yaw_rate = 5.0;  ///< [-] r' beyond which it counts as that | origin: choice
  std::size_t bins = 8;  ///< [bins] of the mean residual over a variable | origin: choice, for the figure
  double taus_per_independent = 2.0;  ///< [tau] after which points count as independent in a bin | origin: theory, a first-order Gauss-Markov process
  double false_discovery = 0.05;  ///< [-] share of wrong ones among the regimes that are reported | origin: choice
};

/// Comparison of hypotheses.
struct ComparePolicy {
  double sets_of_effects = 5.0;  ///< [-] by that nothing missing is believed with 1 to so many before, one effect with 2, two with 1, three with 1/2, and so on | origin: choice
  double least_current_sd = 0.005;  ///< [-] of the greatest sd of a varying current: from there the grid of its sd begins | origin: choice, 0.75 mm/s at 3 m, below what recordings show
  double far_behind_best_start = 5.0;  ///< [nats] of expected gain behind the best start: not tried | origin: choice, time
  double worse_than_without = 2.0;  ///< [nats] below the fit without an effect, or at another scale of the coefficients: it has converged to a worse optimum | origin: choice; at 0 a rudder that lost half its force stayed at 0.67 +- 0.30 for 0.75 nats (docs/gap-method.md)
  double likelier_than_not = 0.5;  ///< [-] stated probability above which a set is chosen against one of fewer names, and nothing missing is not claimed | origin: theory, then fewest names are wrong or missing (Barbieri & Berger 2004, Annals of Statistics 32); without it a pair of an opened development set stated with 0.67 has one name less; what is likelier than nothing missing left 6 of 135 nulls undecided besides
  double strong_odds_beside = 5.0;  ///< [nats] posterior odds of one hypothesis against another that count as strong: 150 to 1 | origin: choice
  double worth_a_name = 0.02;  ///< [-] of the typical acceleration that a further effect must take away where no more is left than inputs between samples make | origin: choice
  double converged_gain = 0.5;  ///< [nats] by which a fit may still gain | origin: choice
  double better_optimum = 2.0;  ///< [nats] by which another optimum of nothing missing must be better | origin: choice
  double same_width = 0.1;  ///< [ln] of a coefficient's width: less is not fitted anew | origin: choice, time
  std::int64_t most_scales = 2;  ///< [fits] that change the common scale of the coefficients' widths | origin: choice, time
  double unexcited = 0.01;  ///< [nats] of evidence: an effect that changes less is not excited | origin: choice
  std::int64_t refit_iterations = 20;  ///< [iterations] of a fit with effects | origin: choice, time
  double far_below = 0.2;  ///< [-] of the model error, from which a fit is begun anew | origin: choice
  std::int64_t most_continuations = 5;  ///< [fits] that continue one that has not converged | origin: choice, time
  std::size_t most_that_differ = 8;  ///< [recordings] in which an effect may differ | origin: choice, time
  std::int64_t most_shifts = 20;  ///< [rounds] of moving a tug's begin and end | origin: choice, time
  double first_shift_s = 8.0;  ///< [s] at 3 m, times sqrt(L): first step of a tug's begin and end | origin: choice
  double last_shift_s = 1.0;  ///< [s] at 3 m, times sqrt(L): last step | origin: choice
  std::array<double, 12> refined_shifts{-32.0, -16.0, -8.0, -4.0, -2.0, -1.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0};  ///< [last steps] of a fitted tug's begin and end that are tried, and over which the evidence is integrated | origin: choice: to three times what a barely visible tug leaves open
  double same_time_s = 1e-9;  ///< [s] by which times of one tug may differ | origin: choice, rounding
  std::size_t leading_terms = 12;  ///< [terms] of the effect unknown of which sets are formed | origin: choice, time
  std::int64_t bank_directions = 8;  ///< [directions] in which banks are sought | origin: choice
  std::int64_t fender_directions = 24;  ///< [directions] in which fenders are sought | origin: choice
  std::int64_t fine_directions = 120;  ///< [directions] of walls where the hull reaches farthest while something acts | origin: choice
  double apart_deg = 15.0;  ///< [deg] between walls that are tried apart | origin: choice
  std::array<double, 3> fender_depths{0.01, 0.03, 0.1};  ///< [L_pp] of a hull in a fender | origin: choice
  std::array<double, 3> line_slacks{0.4, 0.8, 0.95};  ///< [-] of a line's greatest length | origin: choice
  std::int64_t anchors = 3;  ///< [places] of anchors to each side of the middle of the tracks | origin: choice
  double wall_beams = 1.5;  ///< [B] beyond the tracks, and sd, of a wall's distance | origin: choice
  double anchor_lengths = 2.0;  ///< [L_pp] beyond the tracks within which anchors are sought | origin: choice
  double slack_sd = 0.5;  ///< [-] of a line's greatest length: prior sd of its slack | origin: choice
  double prior_reach_sd = 8.0;  ///< [sd] hard bounds of priors of places | origin: choice
  std::size_t refitted = 6;  ///< [effects] that are fitted without linearization | origin: choice, time; the default of an option
  std::size_t most_effects = 4;  ///< [effects] at a time | origin: choice, time; the default of an option
  std::size_t always_refitted = 3;  ///< [effects] with the largest expected gains that are always fitted | origin: choice
  std::size_t next_refitted = 4;  ///< [effects] that are fitted beside what was chosen | origin: choice, time
  double hopeless_share = 0.5;  ///< [-] of the evidence that was gained: what is expected to gain less is not fitted any more | origin: choice, time
  double hopeless_share_of_places = 0.8;  ///< [-] the same of places: they are many, and a step towards the best of many expects too much | origin: choice
  double far_behind = 20.0;  ///< [nats] and as far behind | origin: choice
  double far_behind_of_look_alikes = 40.0;  ///< [nats] the same of what the likeliest looks like | origin: choice
  double beyond_doubt = 2000.0;  ///< [nats] by which what is missing leads nothing missing, which is not fitted once more then | origin: choice, time: long campaigns alone gain so much
  double close_odds = 3.0;  ///< [nats] of posterior odds within which fits are continued before they are compared | origin: choice
  std::size_t places_at_a_time = 12;  ///< [places] in one screen, which also asks what each two columns have in common: between places that is not needed | origin: choice, time
  std::size_t starts_of_places = 4;  ///< [starts] of a bank, a fender or a line | origin: choice, time
  std::size_t leading_singles = 2;  ///< [effects] beside which pairs are sought | origin: choice, time
  std::size_t leading_pairs = 2;  ///< [pairs] that are fitted although expected to be a little less likely than what was found | origin: choice, time
  std::array<double, 5> latent_sizes{0.1, 0.3, 1.0, 3.0, 9.0};  ///< [reference accelerations] root mean square of a latent force | origin: choice, from a tenth of what is worth finding to far more
  std::array<double, 2> latent_lengths{1.5, 5.0};  ///< [L_pp] over which a force that depends on the place changes | origin: choice
  std::array<double, 2> lengths_of_one_state{0.5, 2.0};  ///< [sd] over which a force changes with one state, by that state's own | origin: choice, from a sudden change to nearly a straight line
  std::array<double, 2> lengths_of_two_states{1.0, 4.0};  ///< [sd] the same with two | origin: choice, the same
  std::int64_t latent_harmonics = 3;  ///< [harmonics] of the heading | origin: choice
  std::int64_t latent_periods = 20;  ///< [periods] that are tried, in equal ratios | origin: choice: nearer than a coherent oscillation tells apart
  double shortest_period_s = 8.0;  ///< [s] at 3 m, times sqrt(L) | origin: choice
  double longest_period_s = 100.0;  ///< [s] at 3 m, times sqrt(L) | origin: choice
  double coherent_periods = 3.0;  ///< [periods] after which an oscillation has lost its phase | origin: choice
  double coherent_share = 0.17;  ///< [-] of a recording: or after this part of it | origin: choice, time
  std::array<double, 3> fading_s{5.0, 15.0, 45.0};  ///< [s] at 3 m, times sqrt(L): in which the past fades | origin: choice
  std::int64_t ringing_periods = 17;  ///< [periods] with which it rings, in equal ratios | origin: choice: nearer than its damping tells apart
  double shortest_ringing_s = 4.0;  ///< [s] at 3 m, times sqrt(L) | origin: choice
  double longest_ringing_s = 40.0;  ///< [s] at 3 m, times sqrt(L) | origin: choice
  double ringing_damping = 0.1;  ///< [-] of critical damping | origin: choice
  double certain_motion_sd = 3.0;  ///< [sd] as it is known: what a motion or order changes by, or its past differs from the present by, at least, for a force to depend on it | origin: choice
  std::array<double, 2> latent_errors{0.5, 0.25};  ///< [-] of the model error, that may be left beside a latent force | origin: choice
  std::size_t latent_leading = 2;  ///< [variants] of a kind that are tried with less model error | origin: choice, time
  std::int64_t latent_landmarks = 120;  ///< [points] between which a latent force is interpolated | origin: choice, time
  std::int64_t latent_places = 60;  ///< [places] along the tracks about which a force may act, at most | origin: choice, time
  std::int64_t latent_functions = 12;  ///< [columns] at most, of one axis | origin: choice, time
  double latent_share = 0.01;  ///< [-] of a latent force's variance: columns with less are left out | origin: choice
  std::size_t most_tugs = 8;  ///< [intervals] of different recordings | origin: choice, time
  double position_evidence = 5.0;  ///< [nats] for a residual that depends on the position: walls and lines are tried | origin: choice
  std::size_t draws_of_nothing = 4000;  ///< [draws] of campaigns in which nothing is missing | origin: choice, time
  double strong_terms = 10.0;  ///< [nats] posterior odds for terms of the unknown: another form of forces gains up to 8 | origin: measured, docs/proof.md
  double fewer_are_likelier = 2.0;  ///< [-] prior odds of one number of effects against one more, from one effect on | origin: choice
  double families_beside = 2.0;  ///< [-] families of tests beside a hypothesis: effects and intervals | origin: theory, Bonferroni
  double negligible_share = 0.05;  ///< [-] of the evidence of what is named: -ln p of what is left is not worth a word | origin: choice
  double least_p = 1e-300;  ///< [-] floor of a p-value before its logarithm | origin: choice, rounding
  std::size_t refitted_beside = 3;  ///< [effects] that are tested anew with noise levels that fit them, beside what was chosen | origin: choice, time
  std::int64_t quadrature = 60;  ///< [points] in time of a course's covariance | origin: choice
  std::int64_t grid = 60;  ///< [values] of the standard deviation and of the time constant of a varying current | origin: choice
  double widest_sd = 8.0;  ///< [sd] of the process's prior that the grid covers | origin: choice
};

/// Verdicts, and corrections with the simulator's help.
struct DecidePolicy {
  double families = 3.0;  ///< [-] families of tests that share the rate of false alarms: of the sensors, for effects, for intervals | origin: theory, Bonferroni
  double nearly = 5.0;  ///< [-] p-values up to this times the rate leave it open | origin: choice
  double heldout_sd = 2.0;  ///< [sd] by which an effect must predict better what was held out, tested alone or compared with another hypothesis | origin: choice, one-sided 2 %
  double heldout_sd_if_certain = 1.0;  ///< [sd] the same where p is below the square of the rate | origin: choice
  double error_of_inputs = 0.05;  ///< [-] of the typical acceleration: what inputs between the samples can make | origin: measured, noise-free simulations sampled at 1 Hz
  std::size_t fewest_samples = 300;  ///< [measurements] below which nothing can be excluded | origin: choice
  double far_parameter_sd = 4.0;  ///< [stated sd] a parameter farther off stands for something else | origin: choice
  std::size_t far_parameters = 4;  ///< [parameters] as far off: the simulator errs grossly | origin: choice
  std::size_t far_parameters_with_error = 2;  ///< [parameters] as far off beside a large model error: grossly as well | origin: choice
  double gross_error = 0.5;  ///< [-] model error by typical acceleration that counts as large there | origin: choice
  double error_of_forms = 0.1;  ///< [-] of the typical acceleration: what simulators leave that lack nothing; less is not called unknown, but for a latent force that is sure | origin: measured, scripts/proof/forms: published forms leave more on the worst axis in a fifth of cases
  double stated_sds = 2.0;  ///< [stated sd] beyond which a coefficient's interval contradicts the ship file | origin: choice, 5 %
  double least_determined = 1.0;  ///< [coefficients] that the recordings must know better than the file, to say that it is as stated | origin: choice
  double strong_odds = 5.7;  ///< [nats] posterior odds from which on the p-value is not asked: 300 to 1 | origin: choice
  double unexplained = 0.5;  ///< [-] of the model error's energy that what is named must take away | origin: choice
  double open_reading = 3.0;  ///< [nats] log-odds of a reading that short times do not decide | origin: choice
  double contradicted = 3.0;  ///< [nats] by which recordings are more likely without a faint fault | origin: choice
  double far_likelier = 10.0;  ///< [nats] log-odds by which a fit contradicts a convention | origin: choice
  std::size_t most_compared = 3;  ///< [effects] that may be missing instead | origin: choice, time
  std::int64_t sensed_iterations = 12;  ///< [steps] in which a fault's numbers must settle, or nothing is said of it | origin: choice; five do in eight opened cases
  std::array<std::int64_t, 2> sensed_levels_at{1, 3};  ///< [steps] in which the noise levels follow, outliers judged in the first; numbers settle after the last | origin: choice, once paths know the fault and once more
  std::int64_t sensed_level_steps = 5;  ///< [steps] of BFGS to the noise levels with a fault in the measurement function | origin: choice, time
  std::size_t sensed_parts = 4;  ///< [parts] of a time step of the filter, between which the simulator's path is a spline where sensors are late | origin: measured, a filter of 0.5 s at 1 Hz on a ship that rudders turn fast: with 1 it is 0.7 nats behind a latency, with 4 0.7 ahead; lags as states that go with the ship would need none
  double sensed_step = 0.02;  ///< [usual sizes] of a fault's number to both sides for what it does | origin: choice, far below its sd
  double sensed_converged_sd = 0.1;  ///< [sd] by which a number still moves when it has settled | origin: choice
  double refined_limit_sd = 2.0;  ///< [sd] of the audit within which it stays | origin: choice
};

/// Free runs, stated probabilities, next maneuvers.
struct ShowPolicy {
  std::array<std::int64_t, 3> horizons_s{30, 100, 300};  ///< [s] lengths of free runs | origin: choice, part of the format of report.json
  std::int64_t shown_horizon_s = 100;  ///< [s] length of the free runs that summary and page show | origin: choice, one of them
  double most_speed_mps = 1e3;  ///< [m/s] beyond which a run has diverged | origin: choice, no ship is as fast
  double time_tolerance_s = 1e-9;  ///< [s] by which a free run may be longer | origin: choice, rounding
  double least_error = 1e-12;  ///< [m/s, deg/s, m] floor of an error before its logarithm | origin: choice, rounding
  double worthwhile_fall = 0.05;  ///< [ln] of the errors of free runs over what was left out, for something learned or fitted to be kept | origin: choice
  double as_stated_log_sd = 1e-3;  ///< [ln] sd of a coefficient that is as in the ship file | origin: choice, as good as fixed
  double likelier_nats = 3.0;  ///< [nats] by which coefficients fitted anew must be more likely than those of the ship file | origin: choice
  std::int64_t module_steps = 6;  ///< [steps] of a fit of one module's coefficients alone | origin: choice, time
  double difference_sd = 1e-2;  ///< [posterior sd] of a coefficient, for the slope of a module's force | origin: choice, rounding
  double equal_factors = 0.01;  ///< [-] of their logarithms: below it two numbers of a module changed alike | origin: choice
  std::size_t most_changes = 3;  ///< [quantities] of one module that are told | origin: choice
  double least_direction_sd = 2e-3;  ///< [ln] of coefficients in any direction, of a calibration: least sd | origin: measured, two calibrations by four and two zigzags, whose truth lay 0.2 and 0.4 % off where 0.02 to 0.04 % was left; not tried on others
  double same_log_factor = 1e-3;  ///< [ln] of the factor on a coefficient: nearer to 1 is not written down | origin: choice
  double as_much_rudder = 0.9;  ///< [-] of the rudder of a turning circle: as much was recorded | origin: choice
  std::size_t turning_draws = 64;  ///< [draws] of the posterior that turn with more rudder than was recorded | origin: choice, time
  std::size_t outcome_draws = 4000;  ///< [draws] of what a maneuver would record, for the expected probability of the best hypothesis | origin: choice, time
  double apart_squared = 1e4;  ///< [sd^2] squared distance of hypotheses that nothing could confuse | origin: choice
  double least_probability = 1e-300;  ///< [-] of a hypothesis: floor before its logarithm | origin: choice, rounding
  double longest_step_s = 0.1;  ///< [s] at 3 m, times sqrt(L): time step of a simulated maneuver | origin: choice
  double straight_s = 100.0;  ///< [s] at 3 m, times sqrt(L): duration of a straight run | origin: choice
  double turning_s = 120.0;  ///< [s] at 3 m, times sqrt(L): of a turning circle | origin: choice
  double zigzag_s = 150.0;  ///< [s] at 3 m, times sqrt(L): of a zigzag | origin: choice
  double stopping_s = 120.0;  ///< [s] at 3 m, times sqrt(L): of a coast-down and of a crash stop | origin: choice
  double pull_out_s = 200.0;  ///< [s] at 3 m, times sqrt(L): of a pull-out | origin: choice
  double orders_s = 200.0;  ///< [s] at 3 m, times sqrt(L): of random orders and of thruster pulses | origin: choice
  double turning_rudder_deg = 35.0;  ///< [deg] of a turning circle | origin: theory, IMO MSC.137(76) asks for 35 deg
  double low_speed = 0.5;  ///< [-] of the usual speed, at which some maneuvers are sailed as well | origin: choice
  std::size_t most_sequences = 5;  ///< [sequences] of two maneuvers that are told | origin: choice
  double pull_out_rudder_deg = 20.0;  ///< [deg] before a pull-out | origin: choice
  double decisive = 0.95;  ///< [-] of what any could reach: expected probability of the right name from which on a maneuver decides: of those the shortest is named | origin: choice
  double worthwhile_gain = 0.02;  ///< [-] of that probability: a maneuver that gains less is not recommended | origin: choice
  double not_excluded = 0.3;  ///< [-] of its probability: what is not excluded against a hypothesis | origin: choice
  int judged_interval = 99;  ///< [%] of what the filter expects, in which measurements of given held-out recordings lie | origin: choice
  double least_inside = 0.9;  ///< [-] of them, below which the recordings are not followed | origin: choice, ten times as many outside as there should be
  double credible = 0.95;  ///< [-] of the probability that the fewest likeliest sets hold together | origin: choice, as intervals
  double possible = 0.01;  ///< [-] probability that is worth a word | origin: choice
  double other_form = 0.2;  ///< [-] of what is called unknown: how often it is an effect of the catalogue that acts in another form | origin: measured, docs/proof.md
  double student95 = 2.776;  ///< [sd] reach of intervals of 95 %: Student's with four degrees of freedom | origin: measured, 142 intervals of two sealed runs
  double normal95 = 1.960;  ///< [sd] the same of a normal distribution | origin: theory
  double tail95 = 0.025;  ///< [-] of a distribution, beyond each end of an interval of 95 % | origin: theory
  double least_sd = 1e-12;  ///< [s] floor of a delay's sd before dividing by it | origin: choice, rounding
};

/// Campaigns that are simulated and analyzed again.
struct BootstrapPolicy {
  std::size_t campaigns = 40;  ///< [campaigns] unless the caller says otherwise | origin: choice, time: a share of one half is known to 0.08
  double sharpness_log_sd = 0.5;  ///< [ln] of the power by which stated probabilities are sharpened: sd before any campaign | origin: choice, 0.4 to 2.7 with 95 %
  double sharpness_reach_sd = 4.0;  ///< [sd] within which it is sought | origin: choice
  double sharpness_tolerance = 1e-3;  ///< [ln] to which it is sought | origin: choice, rounding
  double helmsman_course = 0.3;  ///< [rad/rad] rudder by course error, on top of what was recorded | origin: choice: a ship of 3 m that is sampled at 1 Hz keeps her course
  double helmsman_rate = 0.5;  ///< [-] rudder by error of the yaw rate times L/U | origin: choice, the same
};

/// What a report shows.
struct ReportPolicy {
  double least_p = 1e-4;  ///< [-] p-value below which a sentence gives no number | origin: choice
  double least_evidence = 3.0;  ///< [nats] below which the summary says nothing of a frame or a module | origin: choice
  double beyond_hull_L = 0.5;  ///< [L_pp] from midship: a line of action farther off is called a turning moment | origin: theory, the hull ends there
  double shifted_sd = 2.0;  ///< [sd] as stated, and as fitted, by which a coefficient must be off to be listed | origin: choice, 5 %
  std::size_t most_recordings = 4;  ///< [recordings] whose own values of an effect are told in a sentence | origin: choice
  std::size_t most_findings = 2;  ///< [findings] of the ship file that the headline tells | origin: choice
  double least_share = 0.005;  ///< [-] of what is missing: less is not worth a word | origin: choice
  double told_as_times = 2.0;  ///< [-] of errors: from here on "3 times", below in per cent | origin: choice
  std::size_t line_width = 100;  ///< [characters] of a line of the summary | origin: choice
  std::size_t label_width = 12;  ///< [characters] of its labels | origin: choice
  std::int64_t most_digits = 3;  ///< [digits] of a number in a headline | origin: choice
  std::int64_t most_decimals = 6;  ///< [digits] of a number in a sentence | origin: choice
  std::size_t points_per_line = 1500;  ///< [points] of a line in the page, about the pixels of a wide screen | origin: choice
  std::size_t points_in_all = 20000;  ///< [points] per axis: keeps a page of many recordings below 3 MB | origin: measured
};

/// By stage, in the order of docs/architecture.md.
struct Policy {
  double reference_length_m = 3.0;  ///< [m] L_pp of the ship for which lengths and times "at 3 m" are stated; others by Froude's law | origin: choice, the models of most tests
  SensorsPolicy sensors;
  FilterPolicy filter;
  FitPolicy fit;
  DetectPolicy detect;
  LocatePolicy locate;
  ComparePolicy compare;
  DecidePolicy decide;
  ShowPolicy show;
  BootstrapPolicy bootstrap;
  ReportPolicy report;
};
// clang-format on
inline constexpr Policy kPolicy;

/// SHA-256 of all values, for the provenance of results.
std::string policy_hash(const Policy& policy = kPolicy);

}  // namespace leeway::gap
