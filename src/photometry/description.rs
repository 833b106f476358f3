//! What a photometric file says of its luminaire in words.

/// Texts of a photometric file; empty where the file has none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Description {
    /// Who makes the luminaire (LM-63 MANUFAC, EULUMDAT line 1).
    pub manufacturer: String,
    /// What the luminaire is called (LUMINAIRE, line 9).
    pub luminaire: String,
    /// Its number in the catalogue (LUMCAT, line 10).
    pub catalogue_number: String,
    /// The lamp in it (LAMP, type of lamps).
    pub lamp: String,
    /// The report of the measurement (TEST, line 8).
    pub report: String,
    /// When it was measured or issued (ISSUEDATE, line 12).
    pub date: String,
    /// All keywords of LM-63 in their order, each with its text; continuations are joined.
    pub keywords: Vec<(String, String)>,
}

impl Description {
    /// A name for lists: the luminaire, or its catalogue number, or its manufacturer.
    pub fn name(&self) -> &str {
        let names = [&self.luminaire, &self.catalogue_number, &self.manufacturer];
        names.into_iter().find(|name| !name.is_empty()).map_or("", String::as_str)
    }

    /// Lines for a panel: manufacturer, luminaire with catalogue number, and lamp; empty ones are left out.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![self.manufacturer.clone()];
        let number = &self.catalogue_number;
        lines.push(match (self.luminaire.is_empty(), number.is_empty()) {
            (false, false) if !self.luminaire.contains(number) => format!("{} ({number})", self.luminaire),
            (true, _) => number.clone(),
            _ => self.luminaire.clone(),
        });
        lines.push(self.lamp.clone());
        lines.retain(|line| !line.is_empty());
        lines.dedup();
        lines
    }

    /// Takes the known keywords of LM-63 over into the fields.
    pub(super) fn of_keywords(keywords: Vec<(String, String)>) -> Self {
        let text = |wanted: &[&str]| {
            let of = |key: &str| {
                keywords
                    .iter()
                    .find(|(name, text)| name == key && !text.is_empty())
                    .map(|(_, text)| text.clone())
            };
            wanted.iter().find_map(|key| of(key)).unwrap_or_default()
        };
        Self {
            manufacturer: text(&["MANUFAC"]),
            luminaire: text(&["LUMINAIRE"]),
            catalogue_number: text(&["LUMCAT"]),
            lamp: text(&["LAMP", "LAMPCAT"]),
            report: text(&["TEST"]),
            date: text(&["ISSUEDATE", "DATE"]),
            keywords,
        }
    }
}
