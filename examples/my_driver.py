"""A driver to begin with: it follows its route at half throttle, and brakes for whoever would come near.

``jaxwalk evaluate --driver my_driver.py:MyDriver`` plays it.
"""

import numpy as np


class MyDriver:
    observes = "route"  # what it sees: 59 numbers, which `jaxwalk observations` lists

    def act(self, observation):  # a row for each episode
        nearest = 10 * observation[:, 23]  # how near somebody comes in the next 3 s if the car keeps its speed [m]
        throttle = np.where(nearest < 2.5, -1.0, 0.5)  # brake fully, or half throttle
        ahead, left = 2.5 * observation[:, 6], 2.5 * observation[:, 7]  # a point of the route, 2.5 m on [m]
        steering = np.arctan2(5 * left, ahead**2 + left**2 + 2.5 * ahead) / 0.52  # a curve through it
        return np.stack([throttle, np.clip(steering, -1, 1)], axis=1)
