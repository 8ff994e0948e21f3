"""Linear finite elements of rigid bodies: six freedoms a body, springs and constraints between points of bodies, NumPy.

Nothing here comes from gough: M and K are put together body by body in W, constraints taken out by their null space.

    displacement of the point P of a body:  d_P = T(P - O) [u; theta],   T(r) = [1 -r x; 0 1]                        (1)
    spring between bodies i and j at P in axes R:  K_e = B' diag-or-full B,   B = R6' (T_j - T_i)                    (2)
"""

from __future__ import annotations

import numpy as np


def cross(r):
    return np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0.0]])


def lever(r):
    """T(r) of eq. (1)."""
    T = np.eye(6)
    T[:3, 3:] = -cross(r)
    return T


class Assembly:
    """Bodies by name; "ground" stands still."""

    def __init__(self):
        self.origin, self.M, self.K, self.rows = {}, [], [], []

    def body(self, name, place, mass=0.0, center=(0, 0, 0), inertia=None, R=None):
        """A body whose motion is told at `place` (3,); `center` from there and `inertia` about it, in axes R."""
        R = np.eye(3) if R is None else R
        c = R @ np.asarray(center, float)
        I = np.zeros((3, 3)) if inertia is None else R @ np.asarray(inertia, float) @ R.T
        T = lever(c)
        self.origin[name] = np.asarray(place, float)
        self.M.append((name, T.T @ np.block([[mass * np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), I]]) @ T))

    def _between(self, first, second, place, R):
        """B of eq. (2) on all freedoms.  (6, n)."""
        names = list(self.origin)
        B = np.zeros((6, 6 * len(names)))
        R6 = np.kron(np.eye(2), np.eye(3) if R is None else R)
        for name, sign in ((first, -1), (second, 1)):
            if name != "ground":
                k = 6 * names.index(name)
                B[:, k : k + 6] = sign * R6.T @ lever(np.asarray(place) - self.origin[name])
        return B

    def spring(self, first, second, place, K, R=None):
        """A spring (6, 6) in axes R at `place`; bodies must all be there."""
        B = self._between(first, second, place, R)
        self.K.append(B.T @ K @ B)

    def tie(self, first, second, place, held, R=None):
        """No relative motion in the components `held` (0-5) of axes R."""
        self.rows.append(self._between(first, second, place, R)[list(held)])

    def system(self):
        """M, K on the free motions, and the null space N (6 bodies, free)."""
        names = list(self.origin)
        n = 6 * len(names)
        M = np.zeros((n, n))
        for name, one in self.M:
            k = 6 * names.index(name)
            M[k : k + 6, k : k + 6] += one
        C = np.concatenate(self.rows) if self.rows else np.zeros((0, n))
        _, s, Vt = np.linalg.svd(C)
        rank = int((s > 1e-9 * s.max()).sum()) if len(s) else 0
        N = Vt[rank:].T
        return N.T @ M @ N, N.T @ sum(self.K) @ N, N

    def frequencies(self):
        """Hz, from the lowest; massless freedoms give none."""
        M, K, _ = self.system()
        mu = np.linalg.eigvals(np.linalg.solve(K, M)).real  # 1 / w^2
        mu = np.sort(mu[mu > 1e-14 * mu.max()])[::-1]
        return 1 / (2 * np.pi * np.sqrt(mu))

    def compliance(self, name):
        """Of a body's place: [displacement; turn] by [f; m].  (6, 6)."""
        _, K, N = self.system()
        k = 6 * list(self.origin).index(name)
        return N[k : k + 6] @ np.linalg.solve(K, N[k : k + 6].T)


def along(n):
    """R whose third axis is n."""
    n = np.asarray(n, float) / np.linalg.norm(n)
    a = np.eye(3)[int(np.argmin(np.abs(n)))]
    x = np.cross(a, n)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(n, x), n], 1)


def hybrid(machine, x, K):
    """The IFMA machine with its actuators locked and the tool tip at x, from the numbers of its sheet; gravity out."""
    b, z0 = machine.base.half_width, machine.base.overhang
    s21 = np.sqrt((x[0] + b) ** 2 + x[1] ** 2 - b**2)
    phi = np.arctan2(x[1], x[0] + b) - np.arctan2(s21, b)
    s65, c, s = s21 + 2 * b * np.sin(phi), np.cos(phi), np.sin(phi)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    pivots = np.array([[-b, 0, -z0], [b, 0, -z0]])
    A_2, A_5 = pivots[0] + R @ [0, s21, 0], pivots[1] + R @ [0, s65, 0]
    out = Assembly()
    e_z = np.diag([0, 0, 1.0])
    for i, (pivot, slide) in enumerate(((pivots[0], A_2), (pivots[1], A_5))):
        # an arm turns about its pivot only, so its other inertias meet constraints
        out.body(f"arm {i}", pivot, machine.arm.mass, [0, machine.arm.center, 0], machine.arm.inertia * e_z, R)
        out.body(f"slide {i}", slide, machine.slide.mass, inertia=machine.slide.inertia * e_z)
    out.body("link 2", A_2, machine.link2.mass, machine.link2.center, machine.link2.inertia, R)
    out.body("link 5", A_5, machine.link5.mass, machine.link5.center, machine.link5.inertia, R)
    out.body("ram", x, machine.ram.mass, machine.ram.center, machine.ram.inertia, R)
    for i, (pivot, slide, link) in enumerate(((pivots[0], A_2, "link 2"), (pivots[1], A_5, "link 5"))):
        out.tie("ground", f"arm {i}", pivot, (0, 1, 2, 3, 4))
        out.tie(f"arm {i}", f"slide {i}", slide, range(6))
        out.spring(f"slide {i}", link, slide, K, R)
    out.tie("link 2", "ram", x, range(6))
    out.tie("link 2", "link 5", A_5, (1, 2, 3, 4, 5), R)
    return out


RIGID = 1e5  # times the springs: for what an element must hold without giving way


def hexapod(machine, x, R, base, strut, platform, masses=True):
    """A hexapod with its motors locked: platform, and both parts of each strut with the spring `strut` N/m between.

    base, platform (6, 3): translational stiffness of the joints in W and in T.  Without `masses` struts weigh nothing.
    """
    out = Assembly()
    B = x[:3] + machine.platform_joints_np() @ R.T
    A = machine.joints.base
    out.body("platform", x[:3], machine.platform.mass, machine.platform.center, machine.platform.inertia, R)
    for i in range(6):
        n = (B[i] - A[i]) / np.linalg.norm(B[i] - A[i])
        S = along(n)
        fixed, moving = machine.strut.fixed, machine.strut.moving
        if masses:
            out.body(f"fixed {i}", A[i], fixed.mass, [0, 0, fixed.center], fixed.transverse * np.diag([1, 1, 0.0]), S)
            out.body(
                f"moving {i}", B[i], moving.mass, [0, 0, -moving.center], moving.transverse * np.diag([1, 1, 0.0]), S
            )
        else:
            out.body(f"fixed {i}", A[i])
            out.body(f"moving {i}", B[i])
    for i in range(6):
        S = along(B[i] - A[i])
        zero = np.zeros((6, 6))
        K = zero.copy()
        K[:3, :3] = np.diag(base[i])
        out.spring("ground", f"fixed {i}", A[i], K)
        K = zero.copy()
        K[2, 2] = strut[i]
        out.spring(f"fixed {i}", f"moving {i}", A[i], K, S)
        out.tie(f"fixed {i}", f"moving {i}", A[i], (0, 1, 3, 4, 5), S)
        out.tie("ground", f"fixed {i}", A[i], (5,), S)  # the fork of the universal joint holds its spin
        K = zero.copy()
        K[:3, :3] = np.diag(platform[i])
        out.spring(f"moving {i}", "platform", B[i], K, R)
    return out


def hexaglide(machine, x, R, guide, center, leg, carriage_joint):
    """A hexaglide with its motors locked: carriages on guides (6, 6) at `center` from their joints, massless legs."""
    out = Assembly()
    B = x[:3] + machine.platform_joints_np() @ R.T
    e, point = machine.rails.direction, machine.rails.point
    length = np.broadcast_to(machine.legs.length, 6)
    out.body("platform", x[:3], machine.platform.mass, machine.platform.center, machine.platform.inertia, R)
    places = []
    for i in range(6):
        s = B[i] - point[i]
        across = s - e[i] * (s @ e[i])
        q = s @ e[i] + machine.rails.side[i] * np.sqrt(length[i] ** 2 - across @ across)
        places.append(point[i] + q * e[i])
        out.body(f"carriage {i}", places[i])
        out.body(f"leg {i}", places[i])
        out.body(f"end {i}", B[i])
    for i in range(6):
        S = along(B[i] - places[i])
        where = places[i] + center
        # the guide gives way in five components; along the rail the motor stands still at the guide
        E = along(e[i])
        six = np.kron(np.eye(2), E)
        free = six.T @ np.linalg.inv(guide) @ six
        kept = [0, 1, 3, 4, 5]
        K = np.zeros((6, 6))
        K[np.ix_(kept, kept)] = np.linalg.inv(free[np.ix_(kept, kept)])
        out.spring("ground", f"carriage {i}", where, K, E)
        out.tie("ground", f"carriage {i}", where, (2,), E)
        K = np.zeros((6, 6))
        K[:3, :3] = np.diag(carriage_joint)
        out.spring(f"carriage {i}", f"leg {i}", places[i], K)
        K = np.zeros((6, 6))
        K[2, 2] = leg
        out.spring(f"leg {i}", f"end {i}", places[i], K, S)
        out.tie(f"leg {i}", f"end {i}", places[i], (0, 1, 3, 4, 5), S)
        out.tie("ground", f"leg {i}", places[i], (5,), S)
        out.tie(f"end {i}", "platform", B[i], (0, 1, 2))
    return out
