#ifndef COSIVA_PHYSICAL_LINE_TRACKING_H
#define COSIVA_PHYSICAL_LINE_TRACKING_H

/* Line tracking from sensor readings only (A16), for the emulated PILS and for microcontrollers: C99, fixed point, no
   heap, no library beyond <stdint.h>.

   A row of reflectance sensors (DEMS) lies across the direction of travel, `row_um` before the wheels' axle. Every
   step takes the readings and the wheels' speed, and gives the curvature that the wheel motors (PMOT) have to drive.
   Sensor 0 is the rightmost. Lateral values are positive to the left, curvatures positive in a left turn. A vehicle
   that drives backwards uses its second row, which lies behind the axle: found in its direction of travel it is the
   same. */

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LT_SENSORS 8

/* NOLINTBEGIN(modernize-use-using): C has no other. */

/* Of the row and of the marking on the floor. */
typedef struct {
  int32_t pitch_um; /* from sensor to sensor, 1000 to 20000 */
  int32_t row_um;   /* of the row before the axle, 20000 to 200000 */
  int32_t line_um;  /* width of the marking, from one pitch to four */
} lt_geometry;

typedef struct {
  uint8_t reading[LT_SENSORS]; /* 0: bare floor … 255: marking under the whole sensor */
  int32_t speed_mmps;          /* of the wheels in the direction of travel, 0 to 3000 */
  int32_t dt_us;               /* since the last step, 1 to 50000 */
} lt_input;

typedef struct {
  int32_t curvature_per_km; /* to be driven, in 0.001/m */
  int32_t offset_um;        /* of the line from the row's centre; the last one while there is none */
  uint8_t line_lost;        /* no marking has been under the row for more than the gap that is bridged */
} lt_output;

/* A marking may have a gap: the algorithms drive on as before over this distance. */
#define LT_GAP_UM 30000
/* No algorithm commands a tighter curve: 0.1 m of radius. */
#define LT_CURVATURE_MAX_PER_KM 10000
/* Curvatures that the observer delays, one for each LT_DELAY_STEP_UM driven. */
#define LT_DELAY 64
#define LT_DELAY_STEP_UM 4000

typedef struct {
  lt_geometry geometry;
  int32_t offset_um;
  int32_t bridged_um; /* driven since the marking was under the row, at most LT_GAP_UM + 1 */
  int32_t curvature_per_km;
  uint8_t started; /* a marking has been found */
  /* centroid_pd: */
  int32_t gain_q16;  /* curvature for each µm of offset */
  int32_t slope_ppm; /* filtered change of the offset for each distance driven */
  /* path_observer: the line at the row, in the body's frame. */
  int32_t slope_urad;
  int32_t bend_per_1000km; /* its curvature, in 0.000001/m */
  int32_t delayed[LT_DELAY];
  int32_t delay_um; /* driven since the last entry */
  int32_t newest;
} lt_state;

/* One algorithm: `init` before the first step, and after the vehicle was off its line. */
typedef struct {
  const char* name;
  void (*init)(lt_state* state, const lt_geometry* geometry);
  void (*step)(lt_state* state, const lt_input* in, lt_output* out);
} lt_algorithm;

/* NOLINTEND(modernize-use-using) */

#define LT_ALGORITHMS 3
extern const lt_algorithm lt_algorithms[LT_ALGORITHMS];

/* The algorithm of this name; a null pointer: there is none. */
const lt_algorithm* lt_find(const char* name);

/* Where the row detects the marking, by the centroid of its readings. Returns 0 where there is none.
   @param offset_um  changed only where there is one */
int lt_locate(const lt_geometry* geometry, const uint8_t reading[LT_SENSORS], int32_t* offset_um);

/* Whether no marking of this width gives these readings: two sensors detect it with one between them that does not, or
   it is much wider than it can be. Then a sensor is stuck, or the floor is dirty. */
int lt_implausible(const lt_geometry* geometry, const uint8_t reading[LT_SENSORS]);

#ifdef __cplusplus
}
#endif

#endif
