#!/usr/bin/env python3
"""A position estimator as an external program: one JSON line per input on standard input, one response per estimate.

    cosiva compare arc_kalman --external "mine=python3 examples/estimator.py"

The position is integrated from odometry, and each reading moves it by a fixed ratio of the distance to the position that
the reading gives: a filter with a constant gain, which needs no matrices and is close to the best one when that ratio is
chosen well.
"""

import json
import math
import sys

GAIN = 0.6  # weight of a reading; near 1 it is the article's reset rule


class Estimator:
    def __init__(self):
        self.x = self.y = self.heading = 0.0
        self.variance = 0.0  # of each coordinate
        self.sensors = {}

    def start(self, start):
        self.x, self.y, self.heading = start["x_m"], start["y_m"], start["heading_rad"]
        self.variance = start["sigma_m"] ** 2
        self.sensors = start["sensors"]

    def odometry(self, step):
        middle = self.heading + 0.5 * step["turn_rad"]
        self.x += step["distance_m"] * math.cos(middle)
        self.y += step["distance_m"] * math.sin(middle)
        self.heading += step["turn_rad"]
        self.variance += self.sensors["distance_variance_per_m"] * abs(step["distance_m"])

    def reading(self, reading):
        # The estimated position of the fiducial, compared with the surveyed one.
        c, s = math.cos(self.heading), math.sin(self.heading)
        x = self.x + c * reading["ahead_m"] - s * reading["left_m"]
        y = self.y + s * reading["ahead_m"] + c * reading["left_m"]
        self.x += GAIN * (reading["x_m"] - x)
        self.y += GAIN * (reading["y_m"] - y)
        self.variance = (1 - GAIN) ** 2 * self.variance + GAIN**2 * self.sensors["fiducial_along_sigma_m"] ** 2

    def range(self, _):
        pass  # ranges to stations are not used

    def estimate(self, _):
        v, h = self.variance, 0.01
        answer = {"x_m": self.x, "y_m": self.y, "heading_rad": self.heading, "covariance": [v, 0, 0, 0, v, 0, 0, 0, h]}
        print(json.dumps(answer), flush=True)


estimator = Estimator()
for line in sys.stdin:
    for kind, what in json.loads(line).items():
        getattr(estimator, kind)(what)
