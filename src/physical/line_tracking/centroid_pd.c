/* Proportional-derivative control of the line's centroid.

   The arc through the axle, along the body's axis, that meets the line at the row has the curvature 2 y / a² (y: the
   line's offset, a: the row's distance from the axle). In a steady curve this arc is the line itself, so the axle keeps
   to the line without an integral term. The derivative adds what damping the motors' lag takes at speed. */
#include "parts.h"

/* Of the derivative's low-pass filter, in distance. */
#define FILTER_UM 15000
/* The derivative term leads by this time: the lag of the motors, and of the sampling. */
#define LEAD_US 20000

void lt_centroid_pd_init(lt_state* state, const lt_geometry* geometry) {
  lt_begin(state, geometry);
  const int64_t row_um = geometry->row_um;
  state->gain_q16 = (int32_t)lt_divide((int64_t)2000000000 * 65536, row_um * row_um);
}

void lt_centroid_pd_step(lt_state* state, const lt_input* in, lt_output* out) {
  const int32_t before_um = state->offset_um;
  const int first = !state->started;
  const int32_t distance_um = lt_distance_um(in);
  if (!lt_read_row(state, in, distance_um, out)) return;
  if (!first && distance_um > 0) {
    const int32_t change_um = state->offset_um - before_um;
    /* slope += (change / distance − slope) · distance / (distance + filter), with one division. */
    state->slope_ppm += (int32_t)lt_divide((int64_t)change_um * 1000000 - (int64_t)state->slope_ppm * distance_um,
                                           distance_um + FILTER_UM);
    state->slope_ppm = lt_limit(state->slope_ppm, 2000000);
  }
  const int64_t lead_um = (int64_t)in->speed_mmps * LEAD_US / 1000;
  const int64_t aimed_um = state->offset_um + lead_um * state->slope_ppm / 1000000;
  lt_command(state, aimed_um * state->gain_q16 / 65536, out);
}
