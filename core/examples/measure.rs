use asperity_core::bsdf::*;
use asperity_core::direction::Direction;
use asperity_core::ndf::{any::AnyDensity,beckmann::Beckmann,density::Density,ggx_facets::GgxFacets,law::{Law,Profile},smith::SmithNormals};
use asperity_core::quantity::{Alpha,RelativeIor};
use asperity_core::math::Real;
use rand_pcg::Pcg64; use rand_core::SeedableRng;
use std::time::Instant;
fn fluxes<L:FirstBounce<f64>>(law:&AllBounces<f64,L>, wi:Direction<f64>)->[f64;4]{
  // single by midpoints + lobe
  let n=250; let mut s=[0.0;2];
  for (k,l) in [Lobe::Reflection,Lobe::Transmission].into_iter().enumerate(){
    for i in 0..n{for j in 0..n{
      let u=[(i as f64+0.5)/n as f64,(j as f64+0.5)/n as f64];
      let Some((m,eta))=law.single.facet(wi,u) else{continue};
      let f=asperity_core::fresnel::dielectric(m.dot(wi).abs(),eta);
      let (wo,w)=match l{Lobe::Reflection=>(wi.reflect(m),f.reflected),_=>{let Some(t)=wi.refract(m,eta) else{continue};(t,f.transmitted)}};
      if (wo.z()*wi.z()>0.0)!=(l==Lobe::Reflection){continue}
      s[k]+=w*law.single.way_out(wi,wo)/(n*n) as f64;
    }}
  }
  let later=law.later.flux(wi);
  [s[0],s[1],later.reflected,later.transmitted]
}
fn run<L:FirstBounce<f64>, D:Density<f64>+Sync>(name:&str, single:L, d:D, eta:RelativeIor<f64>, rows:&[(String,f64,f64)], walks:u32){
  let t=Instant::now(); let law=AllBounces::new(single); let dt=t.elapsed().as_secs_f64()*1e3;
  println!("# {name} construct {dt:.2} ms, size {}", std::mem::size_of_val(&law));
  let (mut md,mut ms)=(0f64,0f64);
  for (side,deg,r) in rows{
    let th=deg.to_radians(); let wi=Direction::from_angles(if side=="air"{th}else{std::f64::consts::PI-th},0.0);
    let f=fluxes(&law,wi);
    md=md.max((f[0]+f[2]-r).abs()); ms=ms.max((f.iter().sum::<f64>()-1.0).abs());
    if walks==0{continue}
    let walk=Walk::new(d,eta); let mut g=Pcg64::seed_from_u64(7); let mut back=0.0; let mut thr=0.0;
    let tw=Instant::now();
    for _ in 0..walks{ let s=walk.sample(wi,&mut||f64::uniform(&mut g)); if let Some(s)=s{ if s.wo.z()*wi.z()>0.0{back+=1.0}else{thr+=1.0} } }
    let nsw=tw.elapsed().as_secs_f64()*1e9/walks.max(1) as f64;
    let w=back/walks as f64; let se=(r*(1.0-r)/walks as f64).sqrt();
    println!("{side:10} {deg:3} ref {r:.5} fast {:.5} (d {:+.5}) sum {:.5} walk d {:+.2} se (d {:+.6}, lost {}) {nsw:.0} ns/walk", f[0]+f[2], f[0]+f[2]-r, f.iter().sum::<f64>(), (w-r)/se, w-r, walks as f64-back-thr);
  }
  for k in [5,10,20,35,50,65,80,87,89]{for s in [0.0,1.0]{let wi=Direction::from_angles((if s>0.0{180.0-k as f64}else{k as f64}).to_radians(),0.0);let f=fluxes(&law,wi); ms=ms.max((f.iter().sum::<f64>()-1.0).abs());}}
  println!("max R dev {md:.5} sum dev {ms:.5}");
}
fn main(){
  let walks:u32=std::env::args().nth(1).map_or(20000,|v|v.parse().unwrap());
  let only=std::env::args().nth(2).unwrap_or_default();
  let eta=RelativeIor::new(1.49).unwrap();
  let dir="/work/shared/data/reference/models/";
  let read=|f:&str|->Vec<Vec<String>>{std::fs::read_to_string(format!("{dir}{f}")).unwrap().lines().filter(|l|!l.starts_with('#')).skip(1).map(|l|l.split(',').map(|s|s.to_string()).collect()).collect()};
  let g=read("ms_ggx_totals.csv");
  for a in ["0.1","0.3","0.7","1.5"]{ if !only.is_empty()&&only!="ggx"{break}
    let rows:Vec<_>=g.iter().filter(|r|r[0]==a).map(|r|(r[1].clone(),r[2].parse().unwrap(),r[3].parse().unwrap())).collect();
    let al=Alpha::new(a.parse().unwrap()).unwrap();
    run(&format!("ggx {a}"),Ggx::new(al,eta),GgxFacets::new(al),eta,&rows,walks);
  }
  let g=read("ms_beckmann_totals.csv");
  for a in ["0.2","0.5","1.0"]{ if !only.is_empty()&&only!="beckmann"{break}
    let rows:Vec<_>=g.iter().filter(|r|r[0]==a).map(|r|(r[2].clone(),r[3].parse().unwrap(),r[4].parse().unwrap())).collect();
    let s:f64=a.parse().unwrap();
    let d=Beckmann::new(Alpha::new(s*2f64.sqrt()).unwrap());
    run(&format!("beckmann {a}"),Microfacet::new(d,eta),d,eta,&rows,walks);
  }
  let g=read("normals_totals.csv");
  for (p,de,n) in [("gauss","10","2"),("cauchy","15","2"),("gauss","20","8"),("cauchy","8","3")]{ if !only.is_empty()&&only!="normals"{break}
    let rows:Vec<_>=g.iter().filter(|r|r[0]==p&&r[1]==de&&r[2]==n).map(|r|(r[4].clone(),r[5].parse().unwrap(),r[10].parse().unwrap())).collect();
    let law=Law::new(if p=="gauss"{Profile::Gauss}else{Profile::Cauchy},de.parse::<f64>().unwrap().to_radians(),n.parse().unwrap(),0.0).unwrap();
    let d:SmithNormals<f64>=SmithNormals::new(law);
    let _=AnyDensity::SmithNormals(d);
    run(&format!("{p} {de} {n}"),Microfacet::new(d,eta),d,eta,&rows,walks);
  }
}
