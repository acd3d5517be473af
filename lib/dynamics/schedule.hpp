#pragma once

#include <string>
#include <vector>

#include "dynamics/maneuvers.hpp"

namespace leeway {

/// Orders by the clock. Each row's orders stand until a later row replaces them; NaN: no new order.
struct Schedule {
  struct Row {
    double t_s;
    std::vector<double> orders;  ///< one per channel [rad], [1/s]
  };
  std::vector<Channel> channels;
  std::vector<Row> rows;             ///< at least one, in the order of time
  std::vector<std::string> notices;  ///< orders beyond the limits of the ship

  double end_s() const { return rows.back().t_s; }
};

/// Reads a schedule (CSV, "-": standard input): `t_s` and columns of the ship's actuators in the names of a trajectory,
/// such as delta_deg or n_p_rps; an empty field keeps the order. Throws InputError for a column that is not one of
/// these, no t_s or no actuator at all, a negative time or one that does not increase, text or nan, and no row.
Schedule read_schedule(const std::string& path, const Ship& ship);

/// Until the first row, the ship keeps the actuators of the start. It takes 200 s beyond the last row (our choice).
std::unique_ptr<Maneuver> scheduled_orders(Schedule schedule);

}  // namespace leeway
