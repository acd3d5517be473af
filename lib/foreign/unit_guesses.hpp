#pragma once

#include <map>
#include <vector>

#include "foreign/column_roles.hpp"

namespace leeway::foreign {

/// Numbers of a table by what they are.
using ChannelValues = std::map<Channel, std::vector<double>>;

/// Mean, and largest absolute value, of those that are there; 0 for none.
double mean_of(const std::vector<double>& values);
double largest_of(const std::vector<double>& values);

/// Units that neither names nor kinematics tell, by the range of the numbers; each is noted, unless the range leaves no
/// choice.
///   speed  over ground, in the unit of u; empty where there is none
void guess_units(Roles& roles, const ChannelValues& values, const std::vector<double>& speed);

}  // namespace leeway::foreign
