/* The formulas of three of the study's schemes in CUDA, and those of Runge-Kutta on Lorenz' equations.
 *
 * Each thread marches one lane from the first step to the last with its state in registers, which is the limit for a
 * kernel that another program generates. The largest energy error of a lane is observed; neither failures nor bounds
 * are tested. Each line of the output has the spring, the scheme, the lane-steps per second, and the result of the last
 * lane. */
#include <cmath>
#include <cstdio>
#include <cuda_runtime.h>
#include <string>
#include <vector>

constexpr int BLOCK = 128, REPEATS = 4, MAX_ITERATIONS = 50;

struct Hardening {
  static constexpr double dt = 0.0015;
  static __device__ double force(double u) { return 100 * u * (1 + 10 * u * u); }
  static __device__ double tangent(double u) { return 100 * (1 + 30 * u * u); }
  static __device__ double potential(double u) { return 50 * u * u * (1 + 5 * u * u); }
};

struct Softening {
  static constexpr double dt = 0.0114;
  static __device__ double force(double u) { return 100 * tanh(u); }
  static __device__ double tangent(double u) { double t = tanh(u); return 100 * (1 - t * t); }
  static __device__ double potential(double u) {
    u = fabs(u);
    return 100 * (u + log1p(exp(-2 * u)) - 0.69314718055994531);
  }
};

template <class Spring> struct CentralDifference {
  double u, v = 0, a;
  __device__ CentralDifference(double u0) : u(u0), a(-Spring::force(u0)) {}
  __device__ void step(double dt) {
    u += dt * v + dt * dt / 2 * a;
    double a_new = -Spring::force(u);
    v += dt / 2 * (a + a_new);
    a = a_new;
  }
};

template <class Spring> struct RungeKutta {
  double u, v = 0;
  __device__ RungeKutta(double u0) : u(u0) {}
  __device__ void step(double dt) {
    double u1 = dt * v, v1 = -dt * Spring::force(u);
    double u2 = dt * (v + v1 / 2), v2 = -dt * Spring::force(u + u1 / 2);
    double u3 = dt * (v + v2 / 2), v3 = -dt * Spring::force(u + u2 / 2);
    double u4 = dt * (v + v3), v4 = -dt * Spring::force(u + u3);
    u += (u1 + 2 * (u2 + u3) + u4) * (1.0 / 6);
    v += (v1 + 2 * (v2 + v3) + v4) * (1.0 / 6);
  }
};

template <class Spring> struct AverageAcceleration {
  double u, v = 0, a;
  __device__ AverageAcceleration(double u0) : u(u0), a(-Spring::force(u0)) {}
  __device__ void step(double dt) {
    double c = dt * dt / 4, u_predicted = u + dt * v + c * a, v_predicted = v + dt / 2 * a, before = 0;
    for (int iteration = 0; iteration < MAX_ITERATIONS; iteration++) {
      double at = u_predicted + c * a, correction = (a + Spring::force(at)) / (1 + c * Spring::tangent(at));
      a -= correction;
      double moved = fabs(c * correction), size = fabs(u_predicted) + fabs(c * a);
      bool foretold = moved <= 1e-8 * size && moved * moved * moved <= 1e-17 * size * before * before;
      if (moved <= 1e-12 * size || foretold) break;
      before = moved;
    }
    u = u_predicted + c * a;
    v = v_predicted + dt / 2 * a;
  }
};

template <class Spring, class Scheme> __global__ void march(const double *u0, double *error, int lanes, int steps, double dt) {
  int lane = blockIdx.x * blockDim.x + threadIdx.x;
  if (lane >= lanes) return;
  Scheme motion(u0[lane]);
  double energy = Spring::potential(u0[lane]), largest = 0;
  for (int step = 0; step < steps; step++) {
    motion.step(dt);
    largest = fmax(largest, fabs(0.5 * motion.v * motion.v + Spring::potential(motion.u) - energy));
  }
  error[lane] = largest / energy;
}

template <class Number> struct Point { Number x, y, z; };

template <class Number> __device__ Point<Number> slope(Point<Number> p, Number rho) {
  return {10 * (p.y - p.x), p.x * (rho - p.z) - p.y, p.x * p.y - Number(8.0 / 3) * p.z};
}

template <class Number> __device__ Point<Number> moved(Point<Number> p, Number c, Point<Number> k) {
  return {p.x + c * k.x, p.y + c * k.y, p.z + c * k.z};
}

template <class Number> __global__ void lorenz(const Number *rhos, Number *end, int lanes, int steps, Number dt) {
  int lane = blockIdx.x * blockDim.x + threadIdx.x;
  if (lane >= lanes) return;
  Number rho = rhos[lane];
  Point<Number> p = {1, 0, 0};
  for (int step = 0; step < steps; step++) {
    auto k1 = slope(p, rho), k2 = slope(moved(p, dt / 2, k1), rho), k3 = slope(moved(p, dt / 2, k2), rho);
    auto k4 = slope(moved(p, dt, k3), rho);
    p = moved(moved(moved(p, dt / 6, k1), dt / 3, k2), dt / 3, k3);
    p = moved(p, dt / 6, k4);
  }
  end[lane] = p.x;
}

template <class Number, class Kernel>
void timed(const char *problem, const char *scheme, Kernel kernel, Number low, Number high, int lanes, int steps, double dt) {
  std::vector<Number> host(lanes);
  for (int k = 0; k < lanes; k++) host[k] = low + (high - low) * k / (lanes - 1);
  Number *input, *output;
  cudaMalloc(&input, lanes * sizeof(Number));
  cudaMalloc(&output, lanes * sizeof(Number));
  cudaMemcpy(input, host.data(), lanes * sizeof(Number), cudaMemcpyHostToDevice);
  cudaEvent_t begin, end;
  cudaEventCreate(&begin);
  cudaEventCreate(&end);
  float least = INFINITY;
  for (int repeat = 0; repeat < REPEATS; repeat++) {
    float milliseconds;
    cudaEventRecord(begin);
    kernel<<<(lanes + BLOCK - 1) / BLOCK, BLOCK>>>(input, output, lanes, steps, Number(dt));
    cudaEventRecord(end);
    cudaEventSynchronize(end);
    cudaEventElapsedTime(&milliseconds, begin, end);
    least = fminf(least, milliseconds);
  }
  cudaMemcpy(host.data(), output, lanes * sizeof(Number), cudaMemcpyDeviceToHost);
  if (cudaError_t error = cudaGetLastError()) {
    fprintf(stderr, "%s, %s: %s\n", problem, scheme, cudaGetErrorString(error));
    exit(1);
  }
  printf("%s %s %.6g %.12g\n", problem, scheme, 1e3 * lanes * steps / least, double(host[lanes - 1]));
  cudaFree(input);
  cudaFree(output);
}

template <class Spring> void springs(const char *name, int lanes, int steps) {
  auto run = [&](const char *scheme, auto kernel) { timed<double>(name, scheme, kernel, 0.1, 1.5, lanes, steps, Spring::dt); };
  run("central_difference", march<Spring, CentralDifference<Spring>>);
  run("rk4", march<Spring, RungeKutta<Spring>>);
  run("average_acceleration", march<Spring, AverageAcceleration<Spring>>);
}

int main(int, char **arguments) {
  int lanes = std::stoi(arguments[1]), steps = std::stoi(arguments[2]);
  springs<Hardening>("hardening", lanes, steps);
  springs<Softening>("softening", lanes, steps);
  timed<float>("lorenz", "float32", lorenz<float>, 0, 21, lanes, steps, 0.001);
  timed<double>("lorenz", "float64", lorenz<double>, 0, 21, lanes, steps, 0.001);
}
