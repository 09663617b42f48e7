#ifndef COSIVA_PHYSICAL_LINE_TRACKING_PARTS_H
#define COSIVA_PHYSICAL_LINE_TRACKING_PARTS_H

/* What the algorithms have in common; for this folder only. */

#include <line_tracking.h>

/* Division by a positive number, rounded to the nearest. */
static inline int64_t lt_divide(int64_t value, int64_t by) {
  return value >= 0 ? (value + by / 2) / by : -((-value + by / 2) / by);
}

static inline int32_t lt_limit(int64_t value, int32_t limit) {
  return value > limit ? limit : value < -limit ? -limit : (int32_t)value;
}

/* Clears all but the geometry. */
void lt_begin(lt_state* state, const lt_geometry* geometry);

/* The distance of this step [µm]. */
int32_t lt_distance_um(const lt_input* in);

/* Reads the row. Returns 1 where the marking is under it; `out` has offset and line_lost in either case, and the last
   curvature. */
int lt_read_row(lt_state* state, const lt_input* in, int32_t distance_um, lt_output* out);

/* Stores the curvature, limited, and puts it out. */
void lt_command(lt_state* state, int64_t curvature_per_km, lt_output* out);

void lt_centroid_pd_init(lt_state* state, const lt_geometry* geometry);
void lt_centroid_pd_step(lt_state* state, const lt_input* in, lt_output* out);
void lt_path_observer_init(lt_state* state, const lt_geometry* geometry);
void lt_path_observer_step(lt_state* state, const lt_input* in, lt_output* out);
void lt_threshold_init(lt_state* state, const lt_geometry* geometry);
void lt_threshold_step(lt_state* state, const lt_input* in, lt_output* out);

#endif
