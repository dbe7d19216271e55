"""A kernel of the material point method in Taichi: double precision, quadratic splines, APIC, one pass to the grid and one back.

usage: taichi_mpm.py DIM LAW CELLS STEPS THREADS [PPC]

LAW is `corotated` (singular values), `elastic` (linear in rate form with the Jaumann rate) or `dphencky` (Drucker-Prager in logarithmic
strain, singular values, with the strain out of the plane in two dimensions). The block of edge 1 m starts with a uniform velocity gradient
and oscillates freely, with PPC points per cell and direction and CELLS along its edge."""
import sys, time, resource
import taichi as ti
DIM, LAW, CELLS, STEPS, THREADS = int(sys.argv[1]), sys.argv[2], int(sys.argv[3]), int(sys.argv[4]), int(sys.argv[5])
PPC = int(sys.argv[6]) if len(sys.argv) > 6 else 2
ti.init(arch=ti.cpu, default_fp=ti.f64, cpu_max_num_threads=THREADS, offline_cache=False, log_level=ti.WARN, fast_math=True)
import numpy as np
dx = 1.0 / CELLS; inv_dx = float(CELLS); PAD = 6
n_grid = CELLS + 2 * PAD
n = (CELLS * PPC) ** DIM
rho, E, nu = 2000.0, 1e6, 0.3
lam = E * nu / ((1 + nu) * (1 - 2 * nu)); mu = E / (2 * (1 + nu))
c = ((lam + 2 * mu) / rho) ** 0.5
dt = 0.4 * dx / c
p_vol = (dx / PPC) ** DIM; p_mass = p_vol * rho
phi = np.deg2rad(20.0); sinp = np.sin(phi); alpha = np.sqrt(2 / 3) * 2 * sinp / (3 - sinp)
coh = 0.1 / np.tan(phi) / (3 * lam + 2 * mu) * 3     # shift of the trace for a cohesion of 0.1 Pa
x = ti.Vector.field(DIM, ti.f64, n); v = ti.Vector.field(DIM, ti.f64, n)
C = ti.Matrix.field(DIM, DIM, ti.f64, n)
F = ti.Matrix.field(DIM, DIM, ti.f64, n)            # F, or the stress for elastic
Jp = ti.field(ti.f64, n)                             # elastic: volume ratio; dphencky in 2D: strain out of the plane
gv = ti.Vector.field(DIM, ti.f64, (n_grid,) * DIM); gm = ti.field(ti.f64, (n_grid,) * DIM)
nplastic = ti.field(ti.i32, ())

@ti.func
def stress_update(p):
    """Updates F[p] with C[p]; returns volume * Kirchhoff stress."""
    tau = ti.Matrix.zero(ti.f64, DIM, DIM)
    I = ti.Matrix.identity(ti.f64, DIM)
    if ti.static(LAW == 'elastic'):
        d = dt * 0.5 * (C[p] + C[p].transpose()); w = dt * 0.5 * (C[p] - C[p].transpose())
        s = F[p]
        s = s + w @ s - s @ w + 2 * mu * d + lam * d.trace() * I
        F[p] = s
        Jp[p] *= 1 + d.trace()
        tau = s * Jp[p]
    elif ti.static(LAW == 'corotated'):
        f = (I + dt * C[p]) @ F[p]
        F[p] = f
        U, sig, V = ti.svd(f)
        J = f.determinant()
        tau = 2 * mu * (f - U @ V.transpose()) @ f.transpose() + I * lam * J * (J - 1)
    else:
        # Axes U and logarithms e of the stretches. The singular values of Taichi take shear below 1e-5 for zero in two dimensions.
        f = (I + dt * C[p]) @ F[p]
        U = ti.Matrix.identity(ti.f64, DIM)
        e = ti.Vector.zero(ti.f64, 3)
        if ti.static(DIM == 2):
            b = f @ f.transpose()
            mean = 0.5 * (b[0, 0] + b[1, 1]); half = 0.5 * (b[0, 0] - b[1, 1])
            radius = ti.sqrt(half * half + b[0, 1] * b[0, 1])
            size = ti.sqrt(2 * radius * (radius + ti.abs(half))) + 1e-30
            long, short = (radius + ti.abs(half) + 1e-30) / size, b[0, 1] / size
            if half < 0: long, short = short, long
            U = ti.Matrix([[long, -short], [short, long]])
            e[0] = 0.5 * ti.log(mean + radius)
            e[1] = 0.5 * ti.log(f.determinant() ** 2 / (mean + radius))
            e[2] = Jp[p]
        else:
            U_, sig, V_ = ti.svd(f)
            U = U_
            for i in ti.static(range(DIM)):
                e[i] = ti.log(ti.max(ti.abs(sig[i, i]), 1e-4))
        tr = e.sum() - coh
        eh = e - e.sum() / 3
        nrm = eh.norm() + 1e-30
        if tr >= 0.0:
            for i in ti.static(range(3)): e[i] = coh / 3
            nplastic[None] = 1
        else:
            dg = nrm + (3 * lam + 2 * mu) / (2 * mu) * tr * alpha
            if dg > 0:
                e = e - dg / nrm * eh
                nplastic[None] = 1
        S = ti.Matrix.zero(ti.f64, DIM, DIM); T = ti.Matrix.zero(ti.f64, DIM, DIM)
        for i in ti.static(range(DIM)):
            S[i, i] = ti.exp(e[i]); T[i, i] = 2 * mu * e[i] + lam * e.sum()
        if ti.static(DIM == 2): Jp[p] = e[2]
        F[p] = U @ S @ U.transpose()
        tau = U @ T @ U.transpose()
    return p_vol * tau

@ti.kernel
def clear():
    for I in ti.grouped(gm):
        gv[I] = ti.Vector.zero(ti.f64, DIM); gm[I] = 0.0

@ti.kernel
def p2g():
    for p in x:
        base = (x[p] * inv_dx - 0.5).cast(int)
        fx = x[p] * inv_dx - base.cast(ti.f64)
        w = [0.5 * (1.5 - fx) ** 2, 0.75 - (fx - 1.0) ** 2, 0.5 * (fx - 0.5) ** 2]
        affine = -dt * 4 * inv_dx * inv_dx * stress_update(p) + p_mass * C[p]
        for o in ti.static(ti.grouped(ti.ndrange(*((3,) * DIM)))):
            dpos = (o.cast(ti.f64) - fx) * dx
            wt = 1.0
            for i in ti.static(range(DIM)): wt *= w[o[i]][i]
            gv[base + o] += wt * (p_mass * v[p] + affine @ dpos)
            gm[base + o] += wt * p_mass

@ti.kernel
def grid():
    for I in ti.grouped(gm):
        if gm[I] > 0:
            gv[I] = gv[I] / gm[I]
            for i in ti.static(range(DIM)):
                if I[i] < 2 and gv[I][i] < 0: gv[I][i] = 0
                if I[i] > n_grid - 3 and gv[I][i] > 0: gv[I][i] = 0

@ti.kernel
def g2p():
    for p in x:
        base = (x[p] * inv_dx - 0.5).cast(int)
        fx = x[p] * inv_dx - base.cast(ti.f64)
        w = [0.5 * (1.5 - fx) ** 2, 0.75 - (fx - 1.0) ** 2, 0.5 * (fx - 0.5) ** 2]
        nv = ti.Vector.zero(ti.f64, DIM); nC = ti.Matrix.zero(ti.f64, DIM, DIM)
        for o in ti.static(ti.grouped(ti.ndrange(*((3,) * DIM)))):
            dpos = o.cast(ti.f64) - fx
            wt = 1.0
            for i in ti.static(range(DIM)): wt *= w[o[i]][i]
            q = gv[base + o]
            nv += wt * q
            nC += 4 * inv_dx * wt * q.outer_product(dpos)
        v[p] = nv; C[p] = nC; x[p] += dt * nv

k = np.arange(CELLS * PPC)
pts = np.stack(np.meshgrid(*([(k + 0.5) / PPC * dx] * DIM), indexing='ij'), -1).reshape(-1, DIM) + PAD * dx
x.from_numpy(pts)
gradient = np.array([[-0.06, 0.02, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, 0.01]])[:DIM, :DIM]
v.from_numpy((pts - PAD * dx - 0.5) @ gradient.T)
C.from_numpy(np.tile(gradient, (n, 1, 1)))
F.from_numpy(np.tile(np.zeros((DIM, DIM)) if LAW == 'elastic' else np.eye(DIM), (n, 1, 1)))
Jp.fill(1.0 if LAW == 'elastic' else 0.0)
def step():
    clear(); p2g(); grid(); g2p()
for _ in range(3): step()
ti.sync()
c0 = resource.getrusage(resource.RUSAGE_SELF).ru_utime; t0 = time.perf_counter()
for _ in range(STEPS): step()
ti.sync()
c1 = resource.getrusage(resource.RUSAGE_SELF).ru_utime - c0; t1 = time.perf_counter() - t0
places, speeds = x.to_numpy() - PAD * dx, v.to_numpy()
centre = " ".join(f"{c:.9g}" for c in places.mean(axis=0))
print(f"points {n} steps {STEPS} user {c1:.3f} wall {t1:.3f} plastic {nplastic[None]}")
print(f"centre {centre} kinetic {0.5 * p_mass * (speeds**2).sum():.6g} time {dt * (STEPS + 3):.6g}")
