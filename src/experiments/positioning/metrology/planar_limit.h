#pragma once

#include "cosiva/experiments/positioning/metrology/limit.h"

namespace cosiva::experiments {

/// The posterior Cramér-Rao limit of a vehicle on the plane that follows no line: mean squared distance to the truth of
/// the best filter and of the best smoother over a run's moments, for the odometry, readings and ranges that it had.
/// The information goes along the true drive, J' = (F·J⁻¹·Fᵀ + Q)⁻¹ + Hᵀ·R⁻¹·H, in covariances, where it needs no
/// inverse; the smoother's comes back by Bryson's and Frazier's recursion. What ranges and odometry have in common
/// (scales, delays, reflections) is unknown too, and in the state with the spread that the sensors' figures give it.
/// To first order about the truth, for Gaussian noise as large as those figures say.
/// Source: P. Tichavský, C. Muravchik, A. Nehorai, Posterior Cramér-Rao Bounds for Discrete-Time Nonlinear Filtering,
/// IEEE TSP 46 (1998), equation (21).
/// @param run  has moments, and a start that is known
[[nodiscard]] RunLimit planar_limit_of(const Trial& run);

}  // namespace cosiva::experiments
