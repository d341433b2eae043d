//! Control against published numbers, dense searches and general optimisers.

mod common;
mod equilibrium_point;
mod execution {
    mod model_joint;
}
mod export;
mod identification {
    mod fit;
}
mod motion {
    mod table;
}
mod mpc {
    mod box_qp;
    mod flow;
    mod modulator;
}
mod stiffness {
    mod polygons;
}
mod synthesis;
