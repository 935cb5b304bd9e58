// The pendulum of examples/cartesian_pendulum.acm: index 3.

model CartesianPendulum "a point mass on a circle"
  parameter Real l = 1, m = 1, g = 9.81, phi0 = 0.5235987755982988;
  Real x(start = 0.5), y(start = -0.8660254037844387);
  Real vx(start = 0), vy(start = 0);
  Real lambda, energy;
equation
  vx = der(x);
  vy = der(y);
  m*der(vx) = -lambda*x;
  m*der(vy) = -lambda*y - m*g;
  x^2 + y^2 = l^2;
  energy = m*(vx^2 + vy^2)/2 + m*g*y;
  annotation(experiment(StopTime = 10));
end CartesianPendulum;
