// Which auxiliary images the network reads.

override has_albedo: bool;
override has_normal: bool;
override unorm_normal: bool; // whether normals are stored as 0.5 n + 0.5, or 0 for a miss
