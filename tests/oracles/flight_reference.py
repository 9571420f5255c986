"""A table flown slowly, by SciPy, from what docs/simulation.md says.

Mechanics in another form than the simulator's: coordinates are the turns of both axes relative to
the base and the modes' turns q, with the mass matrix of the rates and the energy's own
derivatives.  Sensors without noise or counts.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline

STEP_S = 0.02
ARCSEC = math.radians(1.0 / 3600.0)


class Reference:
    """Flies two axes of a platform with drives."""

    def __init__(self, platform, drives):
        self.platform, self.drives = platform, drives
        modes = platform.structural_modes
        self.e = np.array([mode.axis_platform for mode in modes]).reshape(-1, 3)
        self.inertia = np.array([drive.inertia_kg_m2 for drive in drives])
        self.mass = np.array([mode.inertia_kg_m2 for mode in modes])
        self.omega = 2.0 * math.pi * np.array([mode.frequency_hz for mode in modes])
        self.damping = np.array([mode.damping for mode in modes])
        self.m = len(modes)
        outer, inner = platform.axes_platform
        # The inner axis, turned about the outer one: its parts along, across and beside it.
        along, beside = outer * (outer @ inner), np.cross(outer, inner)
        parts = np.array([along, inner - along, beside])
        self.e_outer, self.e_parts = self.e @ outer, self.e @ parts.T

    def friction(self, axis, w, z):
        """F and dz/dt over the inertia."""
        drive = self.drives[axis]
        viscous = drive.viscous_per_s * w
        if drive.coulomb_deg_s2 == 0.0:
            return viscous, 0.0
        coulomb = math.radians(drive.coulomb_deg_s2)
        breakaway = math.radians(drive.breakaway_deg_s2)
        sigma_0 = coulomb / (drive.presliding_arcsec * ARCSEC)
        sigma_1 = 2.0 * drive.presliding_damping * math.sqrt(sigma_0)
        share = math.exp(-((w / (drive.stribeck_arcmin_s * 60.0 * ARCSEC)) ** 2))
        dz = w - sigma_0 * abs(w) * z / (coulomb + (breakaway - coulomb) * share)
        return sigma_0 * z + sigma_1 * dz + viscous, dz

    def slope(self, y, torque_rad_s2):
        """Of angles (2), modes' turns (m), their rates (2 + m) and bristles (2)."""
        n = 2 + self.m
        v, z = y[n : 2 * n], y[2 * n :]
        cos, sin = math.cos(y[0]), math.sin(y[0])
        h, dh = np.zeros((2, n)), np.zeros(n)
        h[0, 0] = h[1, 1] = 1.0
        h[0, 2:], h[1, 2:] = self.e_outer, self.e_parts @ (1.0, cos, sin)
        dh[2:] = self.e_parts @ (0.0, -sin, cos)
        matrix = (self.inertia * h.T) @ h
        matrix[2:, 2:] += np.diag(self.mass)
        s_inner = h[1] @ v
        # d/dt(M v) = M v' + M' v; the energy also hangs on the outer angle.
        moving = self.inertia[1] * v[0] * (dh * s_inner + h[1] * (dh @ v))
        force = np.zeros(n)
        force[0] = self.inertia[1] * s_inner * (dh @ v)
        force[2:] = -self.mass * (self.omega**2 * y[2:n] + 2.0 * self.damping * self.omega * v[2:])
        dz = np.zeros(2)
        for axis, drive in enumerate(self.drives):
            rubbed, dz[axis] = self.friction(axis, v[axis], z[axis])
            pull = math.radians(drive.cable_tension_deg_s2) + drive.cable_stiffness_per_s2 * y[axis]
            # A coordinate's own force: the axes turn relative to the base, both of them.
            force[axis] += self.inertia[axis] * (torque_rad_s2[axis] - rubbed - pull)
        return np.concatenate([v, np.linalg.solve(matrix, force - moving), dz])

    def settled(self, angle, rate):
        """Bristles and integrals of axes that have long turned at these rates."""
        z, integral = np.zeros(2), np.zeros(2)
        for axis, drive in enumerate(self.drives):
            if drive.coulomb_deg_s2 and rate[axis]:
                swept = rate[axis] / (drive.stribeck_arcmin_s * 60.0 * ARCSEC)
                level = drive.coulomb_deg_s2 + (
                    drive.breakaway_deg_s2 - drive.coulomb_deg_s2
                ) * math.exp(-(swept**2))
                size = level / drive.coulomb_deg_s2 * drive.presliding_arcsec * ARCSEC
                z[axis] = math.copysign(size, rate[axis])
            integral[axis] = (
                self.friction(axis, rate[axis], z[axis])[0]
                + math.radians(drive.cable_tension_deg_s2)
                + drive.cable_stiffness_per_s2 * angle[axis]
            )
        return z, integral

    def fly(self, table, steps, method="LSODA", rtol=1e-9, atol=1e-11):
        """Angles of the shafts and the base's turn at the beginnings of control steps."""
        told = CubicHermiteSpline(table.t_s, table.position, table.rate_rad_s)
        rate_of = told.derivative()
        latency = np.array([drive.command_latency_s for drive in self.drives])

        def command(t_s):
            since = t_s - latency
            inside = np.maximum(since, 0.0)
            angle = np.array([told(inside[k])[k] for k in range(2)])
            rate = np.array([rate_of(inside[k])[k] for k in range(2)])
            return angle + rate * (since - inside), rate

        n = 2 + self.m
        angle, rate = command(0.0)
        y = np.zeros(2 * n + 2)
        y[:2], y[n : n + 2] = angle, rate
        last, filtered = np.zeros(2), np.zeros(2)
        y[2 * n :], integral = self.settled(angle, rate)
        mean = (command(STEP_S)[1] - rate) / STEP_S
        given = integral + mean
        shaft, flown, turned = y[:2].copy(), [], []
        for tick in range(steps):
            flown.append(shaft.copy())
            turned.append(y[2:n] @ self.e)
            angle, rate = command(tick * STEP_S)
            mean = (command((tick + 1) * STEP_S)[1] - rate) / STEP_S
            wanted, lags = np.empty(2), np.empty(2)
            for axis, drive in enumerate(self.drives):
                w = 2.0 * math.pi * drive.bandwidth_hz
                p = drive.integral * w
                error = angle[axis] - y[axis]
                if tick:
                    keep = math.exp(-10.0 * w * STEP_S)
                    filtered[axis] *= keep
                    filtered[axis] += (1.0 - keep) * (error - last[axis]) / STEP_S
                last[axis] = error
                wanted[axis] = (
                    mean[axis]
                    + integral[axis]
                    + (w**2 + 2.0 * drive.damping * w * p) * error
                    + (2.0 * drive.damping * w + p) * filtered[axis]
                )
                most = (
                    drive.torque_reserve * self.platform.axis_limits[axis].acceleration_max_rad_s2
                )
                if abs(wanted[axis]) > most:
                    wanted[axis] = math.copysign(most, wanted[axis])
                else:
                    integral[axis] += p * w**2 * error * STEP_S
                lags[axis] = drive.lag_s
            before = given.copy()

            late = lags > 0.0
            per_s = -1.0 / np.where(late, lags, 1.0)

            def torque(t, wanted=wanted, left=(before - wanted) * late, per_s=per_s):
                return wanted + left * np.exp(t * per_s)

            found = solve_ivp(
                lambda t, y, torque=torque: self.slope(y, torque(t)),
                (0.0, STEP_S), y, method=method, rtol=rtol, atol=atol,
            )  # fmt: skip
            for gear in found.y[:2].T:
                for axis, drive in enumerate(self.drives):
                    half = 0.5 * drive.backlash_arcsec * ARCSEC
                    shaft[axis] = np.clip(shaft[axis], gear[axis] - half, gear[axis] + half)
            y, given = found.y[:, -1], torque(STEP_S)
        return np.array(flown), np.array(turned)
