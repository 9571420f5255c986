"""Makes tests/data/spacecraft/basilisk_turn.json: a 20 deg turn of the CMG body in Basilisk.

Needs `pip install bsk` (2.12) in an environment of its own; run with that python from the
repository's root.  Four variable-speed CMGs with their rotor and gimbal inertias, driven by
gimbal torques that follow a 20 deg turn; logged are what the gimbals did and how the body
answered.  Nothing of ours is imported.
"""

import json
from pathlib import Path

import numpy as np
from Basilisk.architecture import messaging
from Basilisk.simulation import spacecraft, vscmgStateEffector
from Basilisk.utilities import SimulationBaseClass, macros

H, WHEEL, GIMBAL = 60.0, 0.0955, 0.05  # N m s, kg m^2 about spin, kg m^2 of the frame
OMEGA = H / WHEEL
INERTIA = np.diag([800.0, 500.0, 800.0])
GIMBAL_AXES = np.array([[-1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, 1, 0]])
SPIN = np.tile([0.0, 0.0, 1.0], (4, 1))
START = np.deg2rad([45.0, -45.0, 135.0, -135.0])
AXIS = np.array([0.1, 0.05, 0.99])
TURN_S, STEP_S, LOG_EVERY = 15.0, 0.002, 25


def wanted_rate(t_s):
    """Body rate of a 20 deg quintic turn."""
    u = np.clip((t_s - 1.0) / TURN_S, 0.0, 1.0)
    return np.deg2rad(20.0) / TURN_S * 30.0 * u**2 * (1 - u) ** 2 * AXIS / np.linalg.norm(AXIS)


def jacobian(gamma):
    turned = np.cross(GIMBAL_AXES, SPIN)
    return (np.cos(gamma)[:, None] * turned - np.sin(gamma)[:, None] * SPIN).T


def one_cmg(k):
    cmg = messaging.VSCMGConfigMsgPayload()
    column = lambda v: [[float(x)] for x in v]  # noqa: E731
    cmg.rGB_B = column(np.zeros(3))
    cmg.gsHat0_B, cmg.ggHat_B = column(SPIN[k]), column(GIMBAL_AXES[k])
    cmg.gtHat0_B = column(np.cross(GIMBAL_AXES[k], SPIN[k]))
    cmg.u_s_max = cmg.u_s_min = cmg.u_g_max = cmg.u_g_min = -1.0
    cmg.u_s_f = cmg.u_g_f = 0.0
    cmg.wheelLinearFrictionRatio = cmg.gimbalLinearFrictionRatio = -1.0
    cmg.Omega, cmg.gamma, cmg.gammaDot = OMEGA, START[k], 0.0
    cmg.Omega_max = cmg.gammaDot_max = -1.0
    cmg.massW, cmg.massG = 1e-6, 1e-6  # at the centre of mass: no offsets to account for
    cmg.IW1, cmg.IW2, cmg.IW3 = WHEEL, 0.55 * WHEEL, 0.55 * WHEEL
    cmg.IG1 = cmg.IG2 = cmg.IG3 = GIMBAL
    cmg.IG12 = cmg.IG13 = cmg.IG23 = cmg.IW13 = 0.0
    cmg.rGcG_G = column(np.zeros(3))
    cmg.U_s = cmg.U_d = cmg.l = cmg.L = cmg.d = cmg.rhoG = cmg.rhoW = 0.0
    cmg.VSCMGModel = 0
    return cmg


def main():
    sim = SimulationBaseClass.SimBaseClass()
    step_ns = macros.sec2nano(STEP_S)
    sim.CreateNewProcess("p").addTask(sim.CreateNewTask("t", step_ns))
    body = spacecraft.Spacecraft()
    body.hub.mHub = 1000.0
    # The gyros' own inertia is part of the spacecraft's; at the start it is taken off the hub.
    turned = [np.cross(GIMBAL_AXES[k], SPIN[k]) for k in range(4)]
    own = np.zeros((3, 3))
    for k in range(4):
        c, s = np.cos(START[k]), np.sin(START[k])
        spin, across = c * SPIN[k] + s * turned[k], c * turned[k] - s * SPIN[k]
        own += (WHEEL + GIMBAL) * np.outer(spin, spin)
        own += (0.55 * WHEEL + GIMBAL) * (
            np.outer(across, across) + np.outer(GIMBAL_AXES[k], GIMBAL_AXES[k])
        )
    body.hub.IHubPntBc_B = (INERTIA - own).tolist()
    effector = vscmgStateEffector.VSCMGStateEffector()
    for k in range(4):
        effector.AddVSCMG(one_cmg(k))
    body.addStateEffector(effector)
    sim.AddModelToTask("t", effector)
    sim.AddModelToTask("t", body)
    payload = messaging.VSCMGArrayTorqueMsgPayload()
    message = messaging.VSCMGArrayTorqueMsg().write(payload)
    effector.cmdsInMsg.subscribeTo(message)
    sim.InitializeSimulation()
    manager = body.dynManager
    gammas = manager.getStateObject(effector.nameOfVSCMGGammasState)
    gamma_rates = manager.getStateObject(effector.nameOfVSCMGGammaDotsState)
    speeds = manager.getStateObject(effector.nameOfVSCMGOmegasState)
    omega_state = manager.getStateObject(body.hub.nameOfHubOmega)
    sigma_state = manager.getStateObject(body.hub.nameOfHubSigma)
    read = lambda state: np.array(state.getState()).ravel()  # noqa: E731
    goal, before, rows = START.copy(), np.zeros(4), []
    for k in range(round(20.0 / STEP_S)):
        t_s = k * STEP_S
        gamma, rate = read(gammas), read(gamma_rates)
        omega = np.array(omega_state.getState()).ravel()
        if k % LOG_EVERY == 0:
            sigma = np.array(sigma_state.getState()).ravel()
            rows.append([*gamma, *rate, *omega, *sigma, *read(speeds)])
        d = jacobian(goal)
        momentum_rate = -INERTIA @ (wanted_rate(t_s + 1e-3) - wanted_rate(t_s - 1e-3)) / 2e-3
        goal_rate = np.linalg.pinv(d) @ momentum_rate / H
        goal = goal + STEP_S * goal_rate
        acceleration, before = (goal_rate - before) / STEP_S, goal_rate
        own_inertia = 0.55 * WHEEL + GIMBAL
        torque = own_inertia * (acceleration + 84.0 * (goal_rate - rate) + 3600.0 * (goal - gamma))
        # The rotor's gyroscopic torque on the gimbal axis, h (omega . t), is held off.
        torque = torque - H * (d.T @ omega)
        payload.gimbalTorque = torque.tolist()
        # Rotors are held at speed: their axial torque is what the gimbal's motion would take.
        payload.wheelTorque = [0.0] * 4
        message.write(payload, round(t_s * 1e9))
        sim.ConfigureStopTime(round((k + 1) * STEP_S * 1e9))
        sim.ExecuteSimulation()
    out = {
        "source": "Basilisk 2.12 (bsk), tests/oracles/make_spacecraft_basilisk.py; ISC licence",
        "step_s": STEP_S * LOG_EVERY,
        "inertia_kg_m2": np.diag(INERTIA).tolist(),
        "momentum_n_m_s": H,
        "gimbal_axis_inertia_kg_m2": 0.55 * WHEEL + GIMBAL,
        "wheel_inertia_kg_m2": WHEEL,
        "columns": "gimbal angles rad (4), gimbal rates rad/s (4), body rate rad/s (3), "
        "sigma body from inertial (3), rotor speeds rad/s (4)",
        "rows": [[float(f"{x:.10g}") for x in row] for row in rows],
    }
    path = Path(__file__).parents[1] / "data" / "spacecraft" / "basilisk_turn.json"
    path.write_text(json.dumps(out), encoding="utf-8")
    print(
        path,
        len(rows),
        np.rad2deg(rows[-1][8:11]),
        np.rad2deg(np.max(np.abs(np.array(rows)[:, 8:11]), axis=0)),
    )


if __name__ == "__main__":
    main()
