"""The paper's method in plain dense NumPy: Terze, Mueller, Zlatar (2015), sections 2, 4 to 6, appendices A, B.

Slow, obvious, and written from the paper's hand-derived formulas only, to test what lienumba derives and
compiles. Bodies need `mass` and `inertia` (xx yy zz xy xz yz), joints `type`, `bodies` (-1: ground), `points`
and `length`.
States: r (k,3) global, R (k,3,3) body to global, v (k,3) global, w (k,3) body frame.
"""

import math

import numpy as np

GROUND = -1


# ---------------------------------------------------------------- the group SO(3), section 2 and appendix A
def hat(u):
    """u~, with hat(u) @ w = u x w."""
    return np.array([[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]])


def exp(u):
    """Rodrigues' formula: I + sin t / t u~ + (1 - cos t) / t^2 u~^2, in forms that do not cancel."""
    t = np.linalg.norm(u)
    U = hat(u)
    return np.eye(3) + np.sinc(t / np.pi) * U + 0.5 * np.sinc(t / (2 * np.pi)) ** 2 * U @ U


def bernoulli(n):
    """B_0 ... B_n with B_1 = -1/2."""
    B = [1.0]
    for m in range(1, n + 1):
        B.append(-sum(math.comb(m + 1, k) * B[k] for k in range(m)) / (m + 1))
    return B


def dexpinv_truncated(u, w, n):
    """dexp^-1_{-u}(w), the sum (A.4) to j = n; its sign is (-1)^j, not the single minus of the paper."""
    total, term = np.zeros(3), np.array(w, dtype=float)
    for j, B in enumerate(bernoulli(n)):
        total = total + (-1) ** j * B / math.factorial(j) * term
        term = np.cross(u, term)
    return total


def dexpinv(u, w):
    """dexp^-1_{-u}(w) in closed form; |u| < 2 pi."""
    t = np.linalg.norm(u)
    if t < 0.5:
        return dexpinv_truncated(u, w, 24)
    c = (1 - t / 2 / np.tan(t / 2)) / t**2
    return w + np.cross(u, w) / 2 + c * np.cross(u, np.cross(u, w))


# ---------------------------------------------------------------- constraints, (25)-(28), (36)-(41), (B.1)-(B.6)
def placement(r, R, body):
    return (np.zeros(3), np.eye(3)) if body == GROUND else (r[body], R[body])


def rows_of(joint):
    return {"spherical": 3, "distance": 1}[joint.type]


def separation(joint, r, R):
    """(36): from the second body's point to the first body's point, global frame."""
    (ra, Ra), (rb, Rb) = (placement(r, R, body) for body in joint.bodies)
    return ra + Ra @ joint.points[0] - rb - Rb @ joint.points[1]


def point_jacobian(joint, R, k):
    """(40), (B.5): the separation's rate is this (3, 6k) times the velocities; ground moves nothing."""
    C = np.zeros((3, 6 * k))
    for body, point, sign in zip(joint.bodies, joint.points, (1.0, -1.0), strict=True):
        if body != GROUND:
            C[:, 6 * body : 6 * body + 3] = sign * np.eye(3)
            C[:, 6 * body + 3 : 6 * body + 6] = -sign * R[body] @ hat(point)
    return C


def point_bias(joint, R, w):
    """(41), (B.6): xi of the separation's second derivative."""
    xi = np.zeros(3)
    for body, point, sign in zip(joint.bodies, joint.points, (1.0, -1.0), strict=True):
        if body != GROUND:
            xi -= sign * R[body] @ hat(w[body]) @ hat(w[body]) @ point
    return xi


def residual(joints, r, R):
    """Phi (m,), in metres; a rod of length L between points d apart: (d.d / L - L) / 2."""
    rows = [np.zeros(0)]
    for joint in joints:
        d = separation(joint, r, R)
        rows.append(
            d
            if joint.type == "spherical"
            else np.array([(d @ d / joint.numbers["length"] - joint.numbers["length"]) / 2])
        )
    return np.concatenate(rows)


def jacobian(joints, r, R):
    """C (m, 6k), columns v, w of each body."""
    rows = [np.zeros((0, 6 * len(r)))]
    for joint in joints:
        C = point_jacobian(joint, R, len(r))
        rows.append(C if joint.type == "spherical" else separation(joint, r, R)[None] @ C / joint.numbers["length"])
    return np.concatenate(rows)


def bias(joints, r, R, v, w):
    """xi (m,), with C vdot = xi."""
    rows = [np.zeros(0)]
    velocities = np.hstack([v, w]).ravel()
    for joint in joints:
        xi = point_bias(joint, R, w)
        if joint.type == "distance":
            d, rate = separation(joint, r, R), point_jacobian(joint, R, len(r)) @ velocities
            xi = np.array([(d @ xi - rate @ rate) / joint.numbers["length"]])
        rows.append(xi)
    return np.concatenate(rows)


# ---------------------------------------------------------------- dynamics, eqs. (10)-(14), (29), (30), (43)
def inertia(body):
    xx, yy, zz, xy, xz, yz = body.inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def mass_matrix(bodies):
    M = np.zeros((6 * len(bodies), 6 * len(bodies)))
    for i, body in enumerate(bodies):
        M[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = body.mass * np.eye(3)
        M[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = inertia(body)
    return M


def forces(bodies, gravity, w):
    """Q (6k,): gravity and -w~ J w."""
    return np.concatenate(
        [
            np.concatenate([body.mass * np.asarray(gravity), -np.cross(wi, inertia(body) @ wi)])
            for body, wi in zip(bodies, w, strict=True)
        ]
    )


def solve_kkt(M, C, Q, xi):
    """(13): [M C^T; C 0] [x; multipliers] = [Q; xi]."""
    n, m = len(M), len(C)
    solution = np.linalg.solve(np.block([[M, C.T], [C, np.zeros((m, m))]]), np.concatenate([Q, xi]))
    return solution[:n], solution[n:]


def accelerations(bodies, joints, gravity, r, R, v, w):
    """vdot (k,6): dv/dt global and dw/dt in the body frame; and the multipliers (m,)."""
    vdot, multipliers = solve_kkt(
        mass_matrix(bodies), jacobian(joints, r, R), forces(bodies, gravity, w), bias(joints, r, R, v, w)
    )
    return vdot.reshape(-1, 6), multipliers


def energies(bodies, gravity, r, v, w):
    """Kinetic and potential energy."""
    velocities = np.hstack([v, w]).ravel()
    potential = -sum(body.mass * np.dot(gravity, ri) for body, ri in zip(bodies, r, strict=True))
    return velocities @ mass_matrix(bodies) @ velocities / 2, potential


# ---------------------------------------------------------------- Runge-Kutta-Munthe-Kaas, eqs. (17)-(20)
def moved(state, u):
    """x exp(u): the state with the algebra element u (k,12), parts r R v w."""
    r, R, v, w = state
    turned = np.array([Ri @ exp(ui) for Ri, ui in zip(R, u[:, 3:6], strict=True)])
    return r + u[:, 0:3], turned, v + u[:, 6:9], w + u[:, 9:12]


def step(bodies, joints, gravity, state, h, A, b, truncation=None):
    """(20), one step for an autonomous system: rows of A may be short; dexpinv closed or truncated."""
    slopes = []
    for row in A:
        u = sum((h * float(a) * f for a, f in zip(row, slopes, strict=False)), np.zeros((len(bodies), 12)))
        r, R, v, w = moved(state, u)
        vdot, _ = accelerations(bodies, joints, gravity, r, R, v, w)
        inverse = dexpinv if truncation is None else lambda a, c: dexpinv_truncated(a, c, truncation)
        turning = np.array([inverse(ui, wi) for ui, wi in zip(u[:, 3:6], w, strict=True)])
        slopes.append(np.hstack([v, turning, vdot]))
    return moved(state, sum(h * float(weight) * f for weight, f in zip(b, slopes, strict=True)))


# ---------------------------------------------------------------- stabilisation, eqs. (21), (22)
def project_positions(joints, r, R, tolerance=1e-13, max_iterations=20):
    """The nearest r, R on the constraints, and the iterations.

    In R exp(x~) the paper's norm |R' - R|_F^2 is 2 |x|^2 + O(x^4). Each iteration finds the *total* correction.
    """
    k = len(r)
    W = np.diag([1.0, 1.0, 1.0, 2.0, 2.0, 2.0] * k)
    x = np.zeros((k, 6))
    for iteration in range(max_iterations + 1):
        state = moved((r, R, np.zeros((k, 3)), np.zeros((k, 3))), np.hstack([x, np.zeros((k, 6))]))
        violation = residual(joints, *state[:2])
        if np.abs(violation).max(initial=0.0) <= tolerance:
            return state[0], state[1], iteration
        C = jacobian(joints, *state[:2])
        x = solve_kkt(W, C, np.zeros(6 * k), C @ x.ravel() - violation)[0].reshape(k, 6)
    raise RuntimeError(f"the position projection left {np.abs(violation).max()} after {max_iterations} iterations")


def project_velocities(bodies, joints, r, R, v, w, weight="mass"):
    """The nearest v, w with C [v; w] = 0, in the norm of M ("mass") or I ("identity")."""
    velocities = np.hstack([v, w]).ravel()
    W = mass_matrix(bodies) if weight == "mass" else np.eye(len(velocities))
    C = jacobian(joints, r, R)
    corrected = velocities + solve_kkt(W, C, np.zeros(len(velocities)), -C @ velocities)[0]
    return np.hsplit(corrected.reshape(-1, 6), 2)
