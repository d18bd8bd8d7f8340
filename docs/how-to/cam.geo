// An eccentric cam and its flat follower. Lengths in mm. Mesh: gmsh -2 -format msh22 cam.geo
SetFactory("OpenCASCADE");
Disk(1) = {2, 0, 0, 10}; Disk(2) = {0, 0, 0, 3};
BooleanDifference(11) = { Surface{1}; Delete; }{ Surface{2}; Delete; };
Rectangle(12) = {-6, 10, 0, 14, 4, 0.5};
Physical Surface("cam") = {11}; Physical Surface("follower") = {12};
e = 0.05;
bore() = Curve In BoundingBox {-3 - e, -3 - e, -1, 3 + e, 3 + e, 1};
all() = Boundary { Surface{11}; };
Physical Curve("bore") = {bore()}; all() -= {bore()};
Physical Curve("rim") = {all()};
Physical Curve("head") = Curve In BoundingBox {-7, 13.9, -1, 9, 14.1, 1};
Physical Curve("sole") = Curve In BoundingBox {-5.6, 9.9, -1, 7.6, 10.1, 1};
Field[1] = Box; Field[1].VIn = 0.25; Field[1].VOut = 1.5; Field[1].Thickness = 4;
Field[1].XMin = -1; Field[1].XMax = 8; Field[1].YMin = 7.5; Field[1].YMax = 11;
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0; Mesh.MeshSizeFromPoints = 0;
Mesh.RecombineAll = 1; Mesh.Algorithm = 8; Mesh.RecombinationAlgorithm = 3;
