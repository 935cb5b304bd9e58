// The circuit of examples/rlc.acm for tools that bring no library: the components are in the file.

connector Pin
  Real v(unit = "V");
  flow Real i(unit = "A");
end Pin;

partial model OnePort
  Pin p, n;
  Real v(unit = "V"), i(unit = "A");
equation
  v = p.v - n.v;
  p.i + n.i = 0;
  i = p.i;
end OnePort;

model SineVoltage
  extends OnePort;
  parameter Real V = 1, f = 1;
equation
  v = V*sin(2*3.141592653589793*f*time);
end SineVoltage;

model Resistor
  extends OnePort;
  parameter Real R = 1;
equation
  v = R*i;
end Resistor;

model Inductor
  extends OnePort(i(start = 0));
  parameter Real L = 1;
equation
  L*der(i) = v;
end Inductor;

model Capacitor
  extends OnePort(v(start = 0));
  parameter Real C = 1;
equation
  i = C*der(v);
end Capacitor;

model Ground
  Pin p;
equation
  p.v = 0;
end Ground;

model RLC "series resonant circuit"
  SineVoltage source(V = 10, f = 50);
  Resistor r(R = 100);
  Inductor l(L = 10e-3);
  Capacitor c(C = 1e-6, v(start = 0, fixed = true));
  Ground ground;
equation
  connect(source.p, r.p);
  connect(r.n, l.p);
  connect(l.n, c.p);
  connect(c.n, source.n);
  connect(source.n, ground.p);
  annotation(experiment(StopTime = 0.1));
end RLC;
