#include "dynamics/schedule.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "io/csv.hpp"

namespace leeway {
namespace {

class ScheduledOrders : public Maneuver {
 public:
  explicit ScheduledOrders(Schedule schedule) : schedule_(std::move(schedule)) {}
  std::optional<double> longest_s() const override { return schedule_.end_s() + kAfterLastRow_s; }
  void order(double t_s, const ShipState<double>&, Actuators<double>& command) override {
    for (; next_ < schedule_.rows.size() && schedule_.rows[next_].t_s <= t_s + kSameStep_s; ++next_)
      for (std::size_t i = 0; i < schedule_.channels.size(); ++i)
        if (const double order = schedule_.rows[next_].orders[i]; !std::isnan(order))
          command[schedule_.channels[i]] = order;
  }

 private:
  static constexpr double kSameStep_s = 1e-9, kAfterLastRow_s = 200.0;
  Schedule schedule_;
  std::size_t next_ = 0;
};

bool is_blank(std::string_view field) { return field.find_first_not_of(" \t") == std::string_view::npos; }

}  // namespace

Schedule read_schedule(const std::string& path, const Ship& ship) {
  io::CsvReader csv(path);
  Schedule schedule;
  std::vector<std::string> known{"t_s"};
  for (const Channel channel : ship.actuator_channels()) known.push_back(column_name(channel));
  const std::size_t time_column = csv.column("t_s");
  std::vector<std::size_t> columns;
  for (std::size_t c = 0; c < csv.header().size(); ++c) {
    const std::string& name = csv.header()[c];
    const auto place = std::find(known.begin(), known.end(), name);
    if (place == known.end())
      throw InputError(csv.file(), 1, fmt::format("column '{}'", name),
                       fmt::format("is no order of the ship '{}'; expected {}", ship.name, fmt::join(known, ", ")));
    if (c == time_column) continue;
    schedule.channels.push_back(ship.actuators[static_cast<std::size_t>(place - known.begin()) - 1].channel);
    columns.push_back(c);
  }
  if (columns.empty())
    throw InputError(csv.file(), 1, "",
                     fmt::format("no column with orders; expected some of {}", fmt::join(known, ", ")));

  std::vector<std::size_t> beyond(columns.size(), 0), first_line(columns.size(), 0);
  std::vector<std::string_view> fields;
  while (csv.next(fields)) {
    const double t_s = csv.number(fields[time_column], "t_s", "s");
    if (t_s < 0.0)
      throw InputError(csv.file(), csv.line(), "column 't_s'", fmt::format("expected a time >= 0 s, got {}", t_s));
    if (t_s > kFarthestTime_s)
      throw InputError(csv.file(), csv.line(), "column 't_s'",
                       fmt::format("expected a time of at most {} s, got {}", kFarthestTime_s, t_s));
    if (!schedule.rows.empty() && t_s <= schedule.end_s())
      throw InputError(csv.file(), csv.line(), "column 't_s'",
                       fmt::format("expected a time later than {} s, got {}", schedule.end_s(), t_s));
    Schedule::Row& row = schedule.rows.emplace_back(Schedule::Row{t_s, {}});
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const std::string_view field = fields[columns[i]];
      const Channel channel = schedule.channels[i];
      double order = kMissing;
      if (!is_blank(field))
        order = csv.number(field, csv.header()[columns[i]], info(channel).unit) * column_unit(channel);
      row.orders.push_back(order);
      const Actuator& actuator = *ship.find_actuator(channel);
      if (std::isnan(order) || std::abs(actuator.clip(order) - order) <= 1e-12) continue;
      if (beyond[i]++ == 0) first_line[i] = csv.line();
    }
  }
  if (schedule.rows.empty()) throw InputError(csv.file(), "expected at least one row of orders, found none");
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (beyond[i] == 0) continue;
    const Actuator& actuator = *ship.find_actuator(schedule.channels[i]);
    const double factor = column_unit(actuator.channel);
    schedule.notices.push_back(
        fmt::format("{}:{}: column '{}': {} order{} outside the limits {:g} to {:g} of the ship '{}', "
                    "which stops at them",
                    csv.file(), first_line[i], csv.header()[columns[i]], beyond[i], beyond[i] == 1 ? "" : "s",
                    actuator.min / factor, actuator.max / factor, ship.name));
  }
  return schedule;
}

std::unique_ptr<Maneuver> scheduled_orders(Schedule schedule) {
  return std::make_unique<ScheduledOrders>(std::move(schedule));
}

}  // namespace leeway
