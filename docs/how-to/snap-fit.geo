// A clip with a hook, and the plate it snaps behind. Lengths in mm. Mesh: gmsh -2 -format msh22 snap-fit.geo
r = 0.6;  // rounding of the hook's tip and of the plate's edge: a sharp edge carries no finite pressure
t = r * Tan(Atan(0.6) / 2);  // from the vertex (17, -1.5) of the two tangents to where the arc begins
Point(1) = {0, 0, 0}; Point(2) = {16, 0, 0}; Point(3) = {16, -1.5, 0};
Point(4) = {17 - t, -1.5, 0}; Point(5) = {17 - t, -1.5 + r, 0};
Point(6) = {17 + t * Cos(Atan(0.6)), -1.5 + t * Sin(Atan(0.6)), 0};
Point(7) = {20, 0.3, 0}; Point(8) = {20, 2, 0}; Point(9) = {0, 2, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Circle(4) = {4, 5, 6};
Line(5) = {6, 7}; Line(6) = {7, 8}; Line(7) = {8, 9}; Line(8) = {9, 1};
Curve Loop(1) = {1:8}; Plane Surface(1) = {1};
Point(11) = {20.3, -4, 0}; Point(12) = {24, -4, 0}; Point(13) = {24, -0.4, 0};
Point(14) = {20.3 + r, -0.4, 0}; Point(15) = {20.3 + r, -0.4 - r, 0}; Point(16) = {20.3, -0.4 - r, 0};
Line(11) = {11, 12}; Line(12) = {12, 13}; Line(13) = {13, 14}; Circle(14) = {14, 15, 16}; Line(15) = {16, 11};
Curve Loop(2) = {11:15}; Plane Surface(2) = {2};
Physical Surface("clip") = {1}; Physical Surface("plate") = {2};
Physical Curve("root") = {8}; Physical Curve("hook") = {2:5};
Physical Curve("foot") = {11}; Physical Curve("catch") = {13:15};
Field[1] = Box; Field[1].VIn = 0.2; Field[1].VOut = 0.5; Field[1].Thickness = 2;
Field[1].XMin = 15.5; Field[1].XMax = 22.5; Field[1].YMin = -2; Field[1].YMax = 0.5;
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0; Mesh.MeshSizeFromPoints = 0;
Mesh.RecombineAll = 1; Mesh.Algorithm = 8; Mesh.RecombinationAlgorithm = 3;
