//! A term and a kind of light from outside the crate.

use klieg::lighting::Role;

/// Weighs the term.
pub fn term() -> klieg::Result<klieg::objective::Objective> {
    use klieg::objective::{Needs, Objective, Term};

    static GLOOM: Term = Term {
        name: "gloom",
        title: "Gloom",
        meaning: "how much of the object is in the darkest quarter of the brightnesses",
        needs: Needs::NONE,
        formula: |picture, view, _| {
            let dark: u32 = picture.histogram[..8].iter().sum();
            dark as f32 / view.counts.object().max(1) as f32
        },
    };

    let mut objective = Objective::default();
    objective.weights.set(&GLOOM, 0.5)?;

    Ok(objective)
}

/// A genome of lights of the kind.
pub fn kind(roles: &[Role]) -> klieg::Result<klieg::lighting::genome::Genome> {
    use klieg::lighting::LightKind;
    use klieg::lighting::genome::{Boxes, Genome};
    use klieg::lighting::kinds::alleles::{AZIMUTH, DIFFUSE, SPECULAR};
    use klieg::lighting::kinds::{Allele, Kind};

    const HEIGHT: f32 = 1.6;

    const GROUND: Allele = Allele {
        name: "ground distance",
        range: |space| Some(space.distance),
        get: |light| light.distance * light.elevation.cos(),
        set: |light, ground| {
            light.elevation = HEIGHT.atan2(ground);
            light.distance = HEIGHT.hypot(ground);
        },
        turns: false,
        relation: |_| None,
    };

    static CEILING: Kind = Kind {
        name: "ceiling",
        meaning: "Lamps under a ceiling",
        parallel: false,
        cone: false,
        alleles: &[AZIMUTH, GROUND, DIFFUSE, SPECULAR],
    };

    let genome = Genome::new(roles, LightKind::new(&CEILING), &Boxes::default())?;

    Ok(genome)
}
