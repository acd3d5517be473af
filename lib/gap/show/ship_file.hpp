#pragma once

#include "gap/show/before_after.hpp"

namespace leeway::gap {

/// What the recordings say of the ship's file beside what was named: each module with its coefficients alone fitted and
/// all others as the file has them, over parts that are left out in turn; and the coefficients that were fitted
/// together. Comes after show_before_after(), whose choice of coefficients counts as well.
ShipFile judge_ship_file(const Answered& answered, const Explanation& explanation);

}  // namespace leeway::gap
