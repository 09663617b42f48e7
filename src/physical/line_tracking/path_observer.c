/* State feedback on an observer of the line.

   The observer estimates, at the row, the line's offset y, its slope θ and its curvature κ in the body's frame, from
   the offsets measured and from the curvature that the vehicle drives itself (k). Over a distance ds: y' = θ − k a, θ'
   = κ − k,   κ' = 0. Its gains are those of a fading-weight filter of second order with the pole q in distance. What
   the row has read is driven a later: κ is delayed by the row's distance a from the axle. The feedback has both poles
   at n per metre, and n falls with speed because of the motors' lag. */
#include "parts.h"

#define POLE_PER_M 45
#define NATURAL_PER_M 18
/* n · v stays below this [1/s]. */
#define NATURAL_PER_S 11
/* Twice the damping ratio, in tenths. */
#define DAMPING_TENTHS 20

void lt_path_observer_init(lt_state* state, const lt_geometry* geometry) { lt_begin(state, geometry); }

/* Records the line's curvature for the distance driven, and returns the one of the line under the axle. */
static int32_t remember(lt_state* state, int32_t distance_um) {
  state->delay_um += distance_um;
  while (state->delay_um >= LT_DELAY_STEP_UM) {
    state->delay_um -= LT_DELAY_STEP_UM;
    state->newest = (state->newest + 1) % LT_DELAY;
    state->delayed[state->newest] = state->bend_per_1000km;
  }
  int32_t back = state->geometry.row_um / LT_DELAY_STEP_UM;
  if (back >= LT_DELAY) back = LT_DELAY - 1;
  return state->delayed[(state->newest + LT_DELAY - back) % LT_DELAY];
}

static void correct(lt_state* state, int32_t measured_um, int32_t predicted_um, int32_t distance_um) {
  /* q = p / (1 + p ds), in 1/km; part = q ds, in millionths: both stay finite however long the step is. */
  const int64_t pole_per_km = (int64_t)POLE_PER_M * 1000000000 / (1000000 + (int64_t)POLE_PER_M * distance_um);
  const int64_t part_ppm = pole_per_km * distance_um / 1000;
  const int64_t keep_ppm = 1000000 - part_ppm;
  const int64_t off_um = measured_um - predicted_um;
  const int64_t keep3_ppm = keep_ppm * keep_ppm / 1000000 * keep_ppm / 1000000;
  state->offset_um = (int32_t)(predicted_um + off_um * (1000000 - keep3_ppm) / 1000000);
  /* 1.5 q² ds (2 − q ds), and q³ ds. */
  const int64_t slope_gain_per_km = 3 * pole_per_km * part_ppm / 1000000 * (1000000 + keep_ppm) / 2000000;
  state->slope_urad += (int32_t)lt_limit(off_um * slope_gain_per_km / 1000, 1000000);
  const int64_t bend_gain = pole_per_km * pole_per_km / 1000000 * part_ppm / 1000000; /* 1/m² */
  state->bend_per_1000km += (int32_t)lt_limit(off_um * bend_gain, 5000000);
  state->slope_urad = lt_limit(state->slope_urad, 1000000);
  state->bend_per_1000km = lt_limit(state->bend_per_1000km, 1000 * LT_CURVATURE_MAX_PER_KM);
}

void lt_path_observer_step(lt_state* state, const lt_input* in, lt_output* out) {
  const int first = !state->started;
  const int32_t before_um = state->offset_um;
  const int32_t distance_um = lt_distance_um(in);
  const int64_t row_um = state->geometry.row_um;
  const int found = lt_read_row(state, in, distance_um, out);
  if (!state->started) return;
  if (!first) {
    /* In a gap the prediction stands for the measurement. */
    const int64_t turned_urad = (int64_t)state->curvature_per_km * distance_um / 1000;
    const int32_t predicted_um =
        before_um + (int32_t)(((int64_t)state->slope_urad * distance_um - turned_urad * row_um) / 1000000);
    state->slope_urad += (int32_t)((int64_t)state->bend_per_1000km * distance_um / 1000000 - turned_urad);
    if (found)
      correct(state, state->offset_um, predicted_um, distance_um);
    else
      state->offset_um = predicted_um;
    state->offset_um = lt_limit(state->offset_um, (LT_SENSORS - 1) * state->geometry.pitch_um / 2);
  }
  /* From the row back to the axle, over the line's curvature. */
  const int64_t bend = state->bend_per_1000km;
  const int64_t slope_urad = state->slope_urad - bend * row_um / 1000000;
  const int64_t offset_um =
      state->offset_um - (int64_t)state->slope_urad * row_um / 1000000 + bend * row_um / 1000000 * row_um / 2000000;
  int64_t natural_per_m = NATURAL_PER_M;
  if (natural_per_m * in->speed_mmps > NATURAL_PER_S * 1000) natural_per_m = NATURAL_PER_S * 1000 / in->speed_mmps;
  const int64_t curvature_per_km = remember(state, distance_um) / 1000 +
                                   natural_per_m * natural_per_m * offset_um / 1000 +
                                   DAMPING_TENTHS * natural_per_m * slope_urad / 10000;
  lt_command(state, curvature_per_km, out);
}
