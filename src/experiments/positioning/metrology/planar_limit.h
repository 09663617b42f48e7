#pragma once

#include "cosiva/experiments/positioning/metrology/limit.h"

namespace cosiva::experiments {

/// The posterior Cramér-Rao limit of a vehicle on the plane that follows no path: mean squared distance to the ground
/// truth of the best filter and of the best smoother over a run's moments, for its actual odometry, readings and
/// ranges. The information propagates along the true drive, J' = (F·J⁻¹·Fᵀ + Q)⁻¹ + Hᵀ·R⁻¹·H, in covariances, which
/// need no inverse; that of the smoother follows from Bryson's and Frazier's recursion. Common errors of ranges and
/// odometry (scales, delays, reflections) are unknown too, and are part of the state with the spread of the sensors'
/// data. To first order about the ground truth, for Gaussian noise of the sensors' stated size. Source: P. Tichavský,
/// C. Muravchik, A. Nehorai, Posterior Cramér-Rao Bounds for Discrete-Time Nonlinear Filtering, IEEE TSP 46 (1998),
/// equation (21).
/// @param run  with moments and a known start
[[nodiscard]] RunLimit planar_limit_of(const Trial& run);

}  // namespace cosiva::experiments
