/* Three-level control, as the simplest line followers have: straight on while the line is near the row's centre, a
   curve of fixed curvature towards the line otherwise. The curve must be tighter than any of the circuit's. */
#include "parts.h"

#define CURVE_PER_KM 4000
/* Half of the zone in which the vehicle drives straight on, in parts of the pitch. */
#define QUIET_PITCHES_INVERSE 4

void lt_threshold_init(lt_state* state, const lt_geometry* geometry) { lt_begin(state, geometry); }

void lt_threshold_step(lt_state* state, const lt_input* in, lt_output* out) {
  if (!lt_read_row(state, in, lt_distance_um(in), out)) return;
  const int32_t quiet_um = state->geometry.pitch_um / QUIET_PITCHES_INVERSE;
  const int32_t offset_um = state->offset_um;
  lt_command(state, offset_um > quiet_um ? CURVE_PER_KM : offset_um < -quiet_um ? -CURVE_PER_KM : 0, out);
}
