use asperity::forward::*; use asperity::measurement::*;
use asperity_core::{bsdf::*, quantity::*, ndf::law::*, ndf::normals::*, gonio::*, plate::*};
use std::time::Instant; use std::sync::atomic::AtomicBool;
fn main(){
  let eta=RelativeIor::new(1.49f64).unwrap();
  for (f,a) in [("scan5",0.187),("scan8",0.471)] {
    let m=csv::read(format!("../shared/data/samples/{f}.csv")).unwrap();
    let plan=Plan::of(&m);
    let setup=Setup{sample:Sample::Plate{eta,rough_side:RoughSide::Source},geometry:Geometry::Transmission,aperture_deg:0.6,quantity:Quantity::Flux};
    let y:Vec<f64>=m.readings().iter().map(|r|r.value).collect();
    for k in -2..=2 { let a=a*(1.0+0.01*k as f64);
    let b=Ggx::new(Alpha::new(a).unwrap(),eta);
    let t=Instant::now(); let r=quadrature(&b,&setup,&plan,Effort::Full); let dt=t.elapsed();
    println!("{f} a {a:.4} rmsd {:?} neglected {:.2e} {:?} draft {:?} {:?}", asperity_core::metric::rmsd_percent(&y,&r.values), r.neglected.flux, dt,{let r=quadrature(&b,&setup,&plan,Effort::Draft);asperity_core::metric::rmsd_percent(&y,&r.values)},{let t=Instant::now();let r=quadrature(&b,&setup,&plan,Effort::Draft);t.elapsed()});}
    let b=Normals::<f64>::new(NormalDensity::new(Law::new(Profile::Gauss,a*0.7,2.0,0.0).unwrap()),eta);
    let t=Instant::now(); let r=quadrature(&b,&setup,&plan,Effort::Full); println!("normals {:?} {:?}",asperity_core::metric::rmsd_percent(&y,&r.values),t.elapsed());
    let t=Instant::now(); for _ in 0..10 {let _=NormalDensity::<f64,256>::new(Law::new(Profile::Gauss,a*0.7,2.0,0.0).unwrap());} println!("table {:?}",t.elapsed()/10);
  }
  // quadrature against Monte Carlo
  let stop=AtomicBool::new(false);
  for (a,side,geo) in [(0.187,RoughSide::Source,Geometry::Transmission),(0.471,RoughSide::Source,Geometry::Transmission),(0.187,RoughSide::Detector,Geometry::Transmission),(0.47,RoughSide::Detector,Geometry::Transmission),(0.2,RoughSide::Source,Geometry::Reflection),(0.2,RoughSide::Detector,Geometry::Reflection),(0.003,RoughSide::Source,Geometry::Transmission),(0.003,RoughSide::Detector,Geometry::Reflection),(0.003,RoughSide::Source,Geometry::Reflection)] {
    let b=Ggx::new(Alpha::new(a).unwrap(),eta);
    let setup=Setup{sample:Sample::Plate{eta,rough_side:side},geometry:geo,aperture_deg:0.6,quantity:Quantity::Flux};
    let grid=AngleGrid::gp200();
    let th:Vec<f64>=(0..1801).map(|k|grid.degrees(k)).collect();
    for s in [0.0,30.0,60.0]{
      let t=Instant::now();
      let mc=monte_carlo(&b,&setup,s,&grid,Rays{count:3_000_000,seed:5},&stop,&|_|{}).unwrap();
      let tm=t.elapsed();
      let q=quadrature(&b,&setup,&Plan::product(&[s],&th),Effort::Full);
      // every 7th reading independent
      let (mut chi,mut n,mut worst)=(0.0,0,0.0f64); let (mut sq,mut sm)=(0.0,0.0);
      for k in (0..1801).step_by(7) { sq+=q.values[k]; sm+=mc.values[k]; if mc.std_errors[k]>0.0 && mc.values[k]*3e6>300.0 { let z=(q.values[k]-mc.values[k])/mc.std_errors[k]; chi+=z*z;n+=1;worst=worst.max(z.abs()); } }
      println!("a {a} {side:?} {geo:?} s {s}: chi2/n {:.3} n {n} worst {:.2} sum q/mc {:.5} peak {:.4e} mc {:.4e} negl {:.1e} ({:?})",chi/n as f64,worst,sq/sm,q.values.iter().cloned().fold(0.0,f64::max),mc.values.iter().cloned().fold(0.0,f64::max),q.neglected.flux,tm);
    }
  }
}
