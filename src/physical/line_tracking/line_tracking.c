#include <line_tracking.h>

#include "parts.h"

const lt_algorithm lt_algorithms[LT_ALGORITHMS] = {
    {"centroid_pd", lt_centroid_pd_init, lt_centroid_pd_step},
    {"path_observer", lt_path_observer_init, lt_path_observer_step},
    {"threshold", lt_threshold_init, lt_threshold_step},
};

const lt_algorithm* lt_find(const char* name) {
  for (int i = 0; i < LT_ALGORITHMS; ++i) {
    const char* a = lt_algorithms[i].name;
    const char* b = name;
    while (*a != '\0' && *a == *b) {
      ++a;
      ++b;
    }
    if (*a == *b) return &lt_algorithms[i];
  }
  return 0;
}

/* Readings up to this level are the floor's. */
static const int32_t floor_level = 24;

int lt_locate(const lt_geometry* geometry, const uint8_t reading[LT_SENSORS], int32_t* offset_um) {
  int32_t sum = 0;
  int32_t moment = 0;
  for (int32_t i = 0; i < LT_SENSORS; ++i) {
    const int32_t contrast = reading[i] > floor_level ? reading[i] - floor_level : 0;
    sum += contrast;
    moment += contrast * (2 * i - (LT_SENSORS - 1));
  }
  /* Less than half a sensor is dirt, or the last of a marking that leaves the row. */
  if (sum < (255 - floor_level) / 2) return 0;
  *offset_um = (int32_t)lt_divide((int64_t)moment * geometry->pitch_um, 2 * sum);
  return 1;
}

void lt_begin(lt_state* state, const lt_geometry* geometry) {
  static const lt_state blank;
  *state = blank;
  state->geometry = *geometry;
}

int32_t lt_distance_um(const lt_input* in) { return (int32_t)((int64_t)in->speed_mmps * in->dt_us / 1000); }

int lt_read_row(lt_state* state, const lt_input* in, int32_t distance_um, lt_output* out) {
  const int found = lt_locate(&state->geometry, in->reading, &state->offset_um);
  if (found) {
    state->bridged_um = 0;
    state->started = 1;
  } else if (state->bridged_um <= LT_GAP_UM) {
    state->bridged_um += distance_um;
  }
  out->offset_um = state->offset_um;
  out->line_lost = !found && (!state->started || state->bridged_um > LT_GAP_UM);
  out->curvature_per_km = state->curvature_per_km;
  return found;
}

void lt_command(lt_state* state, int64_t curvature_per_km, lt_output* out) {
  state->curvature_per_km = lt_limit(curvature_per_km, LT_CURVATURE_MAX_PER_KM);
  out->curvature_per_km = state->curvature_per_km;
}

int lt_implausible(const lt_geometry* geometry, const uint8_t reading[LT_SENSORS]) {
  int32_t sum = 0;
  int32_t groups = 0;
  int32_t bare = 1;
  for (int32_t i = 0; i < LT_SENSORS; ++i) {
    const int32_t lit = reading[i] > floor_level;
    if (lit) sum += reading[i];
    if (lit && bare) ++groups;
    bare = !lit;
  }
  /* Half a pitch of tolerance: the field of a sensor at each edge. */
  const int64_t width_um = (int64_t)sum * geometry->pitch_um / 255;
  return groups > 1 || width_um > geometry->line_um + geometry->pitch_um / 2;
}
