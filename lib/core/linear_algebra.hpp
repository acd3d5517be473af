#pragma once

#include <Eigen/Dense>

// Decompositions of matrices whose size is known at run time only: each would take every source that uses it seconds to
// compile, so that they are compiled once, in linear_algebra.cpp.
extern template class Eigen::LLT<Eigen::MatrixXd>;
extern template class Eigen::LDLT<Eigen::MatrixXd>;
extern template class Eigen::PartialPivLU<Eigen::MatrixXd>;
extern template class Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;
