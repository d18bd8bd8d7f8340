// A ring that is crushed until it touches itself: its inner edge is cut into an upper and a lower half. Lengths in mm.
// Mesh: gmsh -2 -format msh22 ring.geo
a = Pi / 15;  // half the angle of each grip
R = 10; r = 8.5; w = Pi / 2 - a;
Point(1) = {0, 0, 0};
Point(2) = {R * Cos(w), R * Sin(w), 0}; Point(3) = {-R * Cos(w), R * Sin(w), 0};
Point(4) = {-R * Cos(w), -R * Sin(w), 0}; Point(5) = {R * Cos(w), -R * Sin(w), 0};
Point(6) = {R, 0, 0}; Point(7) = {-R, 0, 0};
Point(12) = {r * Cos(w), r * Sin(w), 0}; Point(13) = {-r * Cos(w), r * Sin(w), 0};
Point(14) = {-r * Cos(w), -r * Sin(w), 0}; Point(15) = {r * Cos(w), -r * Sin(w), 0};
Point(16) = {r, 0, 0}; Point(17) = {-r, 0, 0};
Circle(1) = {6, 1, 2}; Circle(2) = {2, 1, 3}; Circle(3) = {3, 1, 7};
Circle(4) = {7, 1, 4}; Circle(5) = {4, 1, 5}; Circle(6) = {5, 1, 6};
Circle(11) = {16, 1, 12}; Circle(12) = {12, 1, 13}; Circle(13) = {13, 1, 17};
Circle(14) = {17, 1, 14}; Circle(15) = {14, 1, 15}; Circle(16) = {15, 1, 16};
Line(21) = {6, 16}; Line(22) = {2, 12}; Line(23) = {3, 13}; Line(24) = {7, 17}; Line(25) = {4, 14}; Line(26) = {5, 15};
For i In {1:6}
  n = 21 + (i % 6);
  Curve Loop(i) = {i, n, -(10 + i), -(20 + i)}; Plane Surface(i) = {i};
EndFor
Transfinite Curve {1, 3, 4, 6, 11, 13, 14, 16} = 15; Transfinite Curve {2, 5, 12, 15} = 9; Transfinite Curve {21:26} = 4;
Transfinite Surface {1:6}; Recombine Surface {1:6};
Physical Surface("ring") = {1:6};
Physical Curve("head") = {2}; Physical Curve("foot") = {5};
Physical Curve("upper") = {11, 12, 13}; Physical Curve("lower") = {14, 15, 16};
