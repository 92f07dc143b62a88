use field::*;
fn rng(s:&mut u64)->u64{ *s=s.wrapping_add(0x9E3779B97F4A7C15); let mut z=*s; z=(z^(z>>30)).wrapping_mul(0xBF58476D1CE4E5B9); z=(z^(z>>27)).wrapping_mul(0x94D049BB133111EB); z^(z>>31)}
fn main(){ let engines:Vec<_>=std::env::args().skip(1).collect();
  for p in [Preset::R3,Preset::N,Preset::LB] { let name=p.name.clone(); let m=Model::new(p).unwrap(); print!("{name}");
  for team in TeamSize::ALL { let mut s=7u64; let mut trials=vec![]; for _ in 0..64 { let g=((rng(&mut s) as u128)<<64)|rng(&mut s) as u128; let t=Responses::from_fn(|r|{let n=(g>>(4*r)) as u8&15; Wheels{left:(n&1)+(n>>1&1),right:(n>>2&1)+(n>>3&1)}}); for goal in m.training_goals() { trials.push(Trial{layout:m.training_layout(goal),tables:[t;4]}); } }
   for e in &engines { let e=Engine::named(e).unwrap(); let mut out=vec![]; let mut best=1e9f64; for _ in 0..60 { let t=std::time::Instant::now(); e.run(&m,team,&trials,&mut out); best=best.min(t.elapsed().as_secs_f64()); }  print!("  n={} {} {:.2}",team.get(),e.name(),best*1e9/(trials.len()*270*team.get()) as f64); } } println!(); }
}
