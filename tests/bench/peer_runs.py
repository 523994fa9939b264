"""One peer in its own environment: follows the path of an .npz with a URDF chain, and writes postures and time to another.

Run by `bench_peers.py` with each environment's own Python: peer_runs.py PEER CHAIN.urdf PATH.npz OUT.npz; needs no camrob.
Every peer starts at the same posture, warm-started from point to point, and stops at 1 um and 1e-6 rad or after 20 steps. Joint
limits are kept where the peer's solver knows them.
"""

from __future__ import annotations

import sys
from pathlib import Path
from time import thread_time

import numpy as np

POSITION, ANGLE, MOST = 1e-6, 1e-6, 20
TIP = "tool"
PLANNED = 500  # points that a planner gets


def with_pinocchio(urdf, start, targets):
    """Damped least squares on Pinocchio's kinematics in NumPy; the least step, no second task, no limits."""
    import pinocchio as pin

    model = pin.buildModelFromXML(urdf.read_text())
    data, frame = model.createData(), model.getFrameId(TIP)
    goals = [pin.SE3(T) for T in targets]
    q = _from_values(model, start)
    out = np.empty((len(targets), len(start)))
    begin = thread_time()
    for k, goal in enumerate(goals):
        for _ in range(MOST):
            pin.framesForwardKinematics(model, data, q)
            error = pin.log6(data.oMf[frame].actInv(goal)).vector
            if max(abs(error[:3])) < POSITION and max(abs(error[3:])) < ANGLE:
                break
            J = pin.computeFrameJacobian(model, data, q, frame)
            q = pin.integrate(model, q, J.T @ np.linalg.solve(J @ J.T + 1e-12 * np.eye(6), error))
        out[k] = _values(model, q)
    return out, thread_time() - begin, pin.__version__


def _from_values(model, values):
    q = np.empty(model.nq)
    for i, joint in enumerate(model.joints[1:]):
        if joint.nq == 2:
            q[joint.idx_q : joint.idx_q + 2] = np.cos(values[i]), np.sin(values[i])
        else:
            q[joint.idx_q] = values[i]
    return q


def _values(model, q):
    out = []
    for joint in model.joints[1:]:
        a = q[joint.idx_q : joint.idx_q + joint.nq]
        out.append(np.arctan2(a[1], a[0]) if joint.nq == 2 else a[0])
    return np.array(out)


def with_pink(urdf, start, targets):
    """Pink: a frame task and a weak posture task, solved by quadprog with its limits, a step of one second."""
    import pink
    import pinocchio as pin

    model = pin.buildModelFromXML(urdf.read_text())
    configuration = pink.Configuration(model, model.createData(), _from_values(model, start))
    task = pink.tasks.FrameTask(TIP, position_cost=1.0, orientation_cost=1.0)
    posture = pink.tasks.PostureTask(cost=1e-6)
    posture.set_target(_from_values(model, start))
    model.velocityLimit[:] = 1e3  # the path has no time: a step may go as far as it needs
    goals = [pin.SE3(T) for T in targets]
    out = np.empty((len(targets), len(start)))
    begin = thread_time()
    for k, goal in enumerate(goals):
        task.set_target(goal)
        for _ in range(MOST):
            error = task.compute_error(configuration)
            if max(abs(error[:3])) < POSITION and max(abs(error[3:])) < ANGLE:
                break
            v = pink.solve_ik(configuration, [task, posture], 1.0, solver="quadprog", safety_break=False)
            configuration.integrate_inplace(v, 1.0)
        out[k] = _values(model, configuration.q)
    return out, thread_time() - begin, pink.__version__


def with_placo(urdf, start, targets):
    """Placo: a frame task and a weak joints task, with joint limits."""
    import placo

    plain = urdf.with_name("placo.urdf")
    plain.write_text(_revolute(urdf))
    robot = placo.RobotWrapper(str(plain), placo.Flags.ignore_collisions)
    names = list(robot.joint_names())
    for name, value in zip(names, start, strict=True):
        robot.set_joint(name, value)
    robot.update_kinematics()
    solver = placo.KinematicsSolver(robot)
    solver.mask_fbase(True)
    task = solver.add_frame_task(TIP, targets[0])
    task.configure(TIP, "soft", 1.0, 1.0)
    rest = solver.add_joints_task()
    rest.set_joints(dict(zip(names, map(float, start), strict=True)))
    rest.configure("rest", "soft", 1e-9)
    out = np.empty((len(targets), len(start)))
    begin = thread_time()
    for k, goal in enumerate(targets):
        task.T_world_frame = goal
        for _ in range(MOST):
            solver.solve(True)
            robot.update_kinematics()
            if task.position().error_norm() < POSITION and task.orientation().error_norm() < ANGLE:
                break
        out[k] = [robot.get_joint(name) for name in names]
    from importlib.metadata import version

    return out, thread_time() - begin, version("placo")


def _revolute(urdf):
    """The URDF with wide limits for its endless joints, of which placo tells the cosine otherwise."""
    import xml.etree.ElementTree as ElementTree

    root = ElementTree.fromstring(urdf.read_text())
    for joint in root.findall("joint"):
        if joint.get("type") == "continuous":
            joint.set("type", "revolute")
            joint.find("limit").set("lower", "-1000")
            joint.find("limit").set("upper", "1000")
    return ElementTree.tostring(root, encoding="unicode")


def with_mink(urdf, start, targets):
    """Mink on MuJoCo: a frame task and a weak posture task, with joint limits, solved by daqp."""
    import mink
    import mujoco

    model = mujoco.MjModel.from_xml_string(_for_mujoco(urdf))
    configuration = mink.Configuration(model)
    configuration.update(np.array(start))
    task = mink.FrameTask(TIP, "body", position_cost=1.0, orientation_cost=1.0)
    posture = mink.PostureTask(model, cost=1e-6)
    posture.set_target(np.array(start))
    limits = [mink.ConfigurationLimit(model)]
    goals = [mink.SE3.from_matrix(T) for T in targets]
    out = np.empty((len(targets), len(start)))
    begin = thread_time()
    for k, goal in enumerate(goals):
        task.set_target(goal)
        for _ in range(MOST):
            error = task.compute_error(configuration)
            if max(abs(error[:3])) < POSITION and max(abs(error[3:])) < ANGLE:
                break
            v = mink.solve_ik(configuration, [task, posture], 1.0, "daqp", limits=limits)
            configuration.integrate_inplace(v, 1.0)
        out[k] = configuration.q
    from importlib.metadata import version

    return out, thread_time() - begin, version("mink")


def _for_mujoco(urdf):
    """The URDF with masses that MuJoCo asks for, and its fixed links kept."""
    import xml.etree.ElementTree as ElementTree

    root = ElementTree.fromstring(urdf.read_text())
    for link in root.findall("link"):
        for inertial in link.findall("inertial"):
            link.remove(inertial)
        inertial = ElementTree.SubElement(link, "inertial")
        ElementTree.SubElement(inertial, "mass", value="1")
        ElementTree.SubElement(inertial, "inertia", ixx="1", iyy="1", izz="1", ixy="0", ixz="0", iyz="0")
    mujoco = ElementTree.SubElement(root, "mujoco")
    ElementTree.SubElement(mujoco, "compiler", fusestatic="false", discardvisual="false")
    return ElementTree.tostring(root, encoding="unicode")


def with_roboticstoolbox(urdf, start, targets):
    """Robotics Toolbox: its compiled Levenberg-Marquardt (ik_LM); no second task."""
    import xml.etree.ElementTree as ElementTree

    import roboticstoolbox as rtb
    from spatialmath import SE3

    ets, limits = [], []
    for joint in ElementTree.fromstring(urdf.read_text()).findall("joint"):
        origin = joint.find("origin")
        x, y, z = map(float, origin.get("xyz").split())
        roll, pitch, yaw = map(float, origin.get("rpy").split())
        ets.append(rtb.ET.SE3(SE3(x, y, z) * SE3.Rz(yaw) * SE3.Ry(pitch) * SE3.Rx(roll)))
        if joint.get("type") != "fixed":
            limit = joint.find("limit")
            limits.append([float(limit.get("lower", "-1e3")), float(limit.get("upper", "1e3"))])
            ets.append(rtb.ET.tz() if joint.get("type") == "prismatic" else rtb.ET.Rz())
    chain = rtb.ETS(ets)
    chain.qlim = np.array(limits).T
    tolerance = 0.5 * POSITION**2  # of 0.5 e^T e
    q = np.array(start)
    out = np.empty((len(targets), len(start)))
    begin = thread_time()
    for k, goal in enumerate(targets):
        q = chain.ik_LM(goal, q0=q, ilimit=MOST, slimit=1, tol=tolerance, joint_limits=False)[0]
        out[k] = q
    from importlib.metadata import version

    return out, thread_time() - begin, version("roboticstoolbox-python")


def with_pytorch_kinematics(urdf, start, targets):
    """pytorch-kinematics: damped least squares on its kinematics and Jacobian, a pose a call (it is made for batches)."""
    import pytorch_kinematics as pk
    import torch

    torch.set_num_threads(1)
    chain = pk.build_serial_chain_from_urdf(urdf.read_bytes(), TIP).to(dtype=torch.float64)
    q = torch.tensor(start, dtype=torch.float64)
    out = np.empty((len(targets), len(start)))
    begin = thread_time()
    for k, goal in enumerate(torch.tensor(targets)):
        for _ in range(MOST):
            T = chain.forward_kinematics(q[None]).get_matrix()[0]
            D = goal[:3, :3] @ T[:3, :3].T
            turn = 0.5 * torch.stack([D[2, 1] - D[1, 2], D[0, 2] - D[2, 0], D[1, 0] - D[0, 1]])
            error = torch.cat([goal[:3, 3] - T[:3, 3], turn])
            if error[:3].abs().max() < POSITION and turn.abs().max() < ANGLE:
                break
            J = chain.jacobian(q[None])[0]
            q = q + J.T @ torch.linalg.solve(J @ J.T + 1e-12 * torch.eye(6), error)
        out[k] = q.numpy()
    from importlib.metadata import version

    return out, thread_time() - begin, version("pytorch-kinematics")


def with_trajopt(urdf, start, targets):
    """TrajOpt (Tesseract): all postures at once, squared joint velocities as cost, poses as constraints, no collisions."""
    import xml.etree.ElementTree as ElementTree

    from tesseract_robotics import tesseract_command_language as language
    from tesseract_robotics import tesseract_common as common
    from tesseract_robotics import tesseract_environment as environment
    from tesseract_robotics import tesseract_motion_planners as planners
    from tesseract_robotics import tesseract_motion_planners_trajopt as trajopt

    robot = ElementTree.fromstring(_revolute(urdf))
    for limit in robot.iter("limit"):
        limit.set("velocity", "10")
        limit.set("effort", "10")
    names = [joint.get("name") for joint in robot.findall("joint") if joint.get("type") != "fixed"]
    group = '<robot name="{}"><group name="all"><chain base_link="base" tip_link="{}"/></group></robot>'
    scene, locator = environment.Environment(), common.GeneralResourceLocator()
    if not scene.init(ElementTree.tostring(robot, encoding="unicode"), group.format(robot.get("name"), TIP), locator):
        raise SystemExit("Tesseract does not take the chain")
    scene.setState(names, np.array(start))
    info = common.ManipulatorInfo()
    info.tcp_frame, info.manipulator, info.working_frame = TIP, "all", "base"
    program = language.CompositeInstruction("DEFAULT")
    program.setManipulatorInfo(info)
    for T in targets[:PLANNED]:
        waypoint = language.CartesianWaypoint(common.Isometry3d(T))
        waypoint.setSeed(common.JointState(names, np.array(start)))
        wrapped = language.CartesianWaypointPoly_wrap_CartesianWaypoint(waypoint)
        move = language.MoveInstruction(wrapped, language.MoveInstructionType_LINEAR, "DEFAULT")
        program.appendMoveInstruction(language.MoveInstructionPoly_wrap_MoveInstruction(move))
    composite = trajopt.TrajOptDefaultCompositeProfile()
    composite.collision_constraint_config.enabled = composite.collision_cost_config.enabled = False
    profiles, task = language.ProfileDictionary(), "TrajOptMotionPlannerTask"
    profiles.addProfile(task, "DEFAULT", trajopt.TrajOptDefaultPlanProfile())
    profiles.addProfile(task, "DEFAULT", composite)
    request = planners.PlannerRequest()
    request.instructions, request.env, request.profiles = program, scene, profiles
    begin = thread_time()
    answer = trajopt.TrajOptMotionPlanner(task).solve(request)
    seconds = thread_time() - begin
    if not answer.successful:
        raise SystemExit("TrajOpt finds no plan")
    # the bindings keep nothing alive of their own: every part is held by a name while it is read
    results = answer.results
    flat, rows = results.flatten(), []
    for k in range(len(flat)):
        instruction = flat[k]
        move = language.InstructionPoly_as_MoveInstructionPoly(instruction)
        found = move.getWaypoint()
        state = language.WaypointPoly_as_StateWaypointPoly(found)
        rows.append(np.array(state.getPosition()).ravel())
    from importlib.metadata import version

    return np.array(rows), seconds, version("tesseract-robotics")


def with_roboplan(urdf, start, targets):
    """RoboPlan: its SimpleIk (damped least squares on Pinocchio), whole steps, no restarts, no collisions; no second task."""
    from roboplan import core, simple_ik

    scene = core.Scene("chain", core.loadUrdfSceneDescriptionFromXml(_revolute(urdf)))
    scene.addGroupFromChain("all", "base", TIP)
    group = scene.getJointGroupInfo("all")
    solver = simple_ik.SimpleIk(
        scene,
        simple_ik.SimpleIkOptions(
            group_name="all",
            max_iters=MOST,
            max_restarts=0,
            max_time=1.0,
            step_size=1.0,
            damping=1e-6,
            max_linear_error_norm=POSITION,
            max_angular_error_norm=ANGLE,
            check_collisions=False,
        ),
    )
    q, found, goal = core.JointConfiguration(), core.JointConfiguration(), core.CartesianConfiguration()
    q.joint_names = found.joint_names = group.joint_names
    q.positions, goal.base_frame, goal.tip_frame = np.array(start), "base", TIP
    out = np.empty((len(targets), len(start)))
    begin = thread_time()
    for k, T in enumerate(targets):
        goal.tform = T
        if not solver.solveIk(goal, q, found):
            raise SystemExit(f"point {k} is not met")
        q.positions = out[k] = found.positions
    from importlib.metadata import version

    return out, thread_time() - begin, version("roboplan")


PEERS = {
    "roboplan": with_roboplan,
    "trajopt": with_trajopt,
    "placo": with_placo,
    "pinocchio": with_pinocchio,
    "pink": with_pink,
    "mink": with_mink,
    "roboticstoolbox": with_roboticstoolbox,
    "pytorch-kinematics": with_pytorch_kinematics,
}


def main(peer, urdf, path, out):
    given = np.load(path)
    q, seconds, version = PEERS[peer](Path(urdf), given["start"], given["targets"])
    np.savez(out, q=q, seconds=seconds, version=version)


if __name__ == "__main__":
    main(*sys.argv[1:])
