//! Who may speak to the server: pages of its own alone. It listens on the loopback interface, where every program and
//! every page in a browser of this machine reaches it.

use crate::{Error, Result};
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::fmt::Write;
use std::sync::Arc;

/// Header in which a page says the token.
const TOKEN: &str = "x-klieg-token";

/// What pages may do: nothing but run the server's own script and speak to it.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; \
     connect-src 'self'; font-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Headers of every answer.
const HEADERS: [(header::HeaderName, &str); 5] = [
    (header::CONTENT_SECURITY_POLICY, POLICY),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-store"),
    (header::X_FRAME_OPTIONS, "DENY"),
];

/// Paths that need no token, as nothing private is there.
const OPEN: [&str; 4] = ["/", "/studio.js", "/studio.css", "/icon.svg"];

/// Environment variable with a token, for pages that are to stay open while the server is started again.
pub const TOKEN_VARIABLE: &str = "KLIEG_STUDIO_TOKEN";

/// Fewest characters of a token that is given: those of 128 bits in base 64.
const LEAST_TOKEN: usize = 22;

/// The token that is `given`, or a new one of 128 random bits.
///
/// # Errors
/// [`Error::Argument`] for a short one, and for characters that addresses do not hold as they are.
pub fn token(given: Option<String>) -> Result<String> {
    let Some(token) = given else {
        let mut token = String::new();
        for byte in rand::random::<[u8; 16]>() {
            // Writing to a string does not fail.
            let _ = write!(token, "{byte:02x}");
        }
        return Ok(token);
    };
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_".contains(&byte);
    if token.len() < LEAST_TOKEN || !token.bytes().all(plain) {
        return Err(Error::Argument(format!(
            "{TOKEN_VARIABLE} must be {LEAST_TOKEN} or more letters, digits, '-' and '_'; without it each start has a new token"
        )));
    }
    Ok(token)
}

/// What tells own pages from others.
#[derive(Debug)]
pub struct Guard {
    token: String,
    hosts: [String; 2],
}

impl Guard {
    /// For a server at this port.
    pub fn new(port: u16, token: String) -> Self {
        Self { token, hosts: [format!("127.0.0.1:{port}"), format!("localhost:{port}")] }
    }

    /// Where the page is, its token included.
    pub fn address(&self) -> String {
        format!("http://{}/?token={}", self.hosts[0], self.token)
    }

    /// Whether the name that a request came by, and the page that it came from, are the server's own. Else another site's
    /// page may speak through a name that leads to this machine (DNS rebinding), or straight across origins.
    fn is_own(&self, headers: &HeaderMap) -> bool {
        let text = |value: &HeaderValue| value.to_str().unwrap_or_default().to_owned();
        let host = headers.get(header::HOST).map(text);
        let host = host.is_some_and(|host| self.hosts.contains(&host));
        let own = |origin: String| {
            self.hosts.iter().any(|host| origin.strip_prefix("http://") == Some(host))
        };
        host && headers.get(header::ORIGIN).map(text).is_none_or(own)
    }

    /// Whether a request carries the token: in its header, or in its query, as a WebSocket's has to.
    fn has_token(&self, request: &Request) -> bool {
        let said = request.headers().get(TOKEN).and_then(|value| value.to_str().ok());
        let query = request.uri().query().unwrap_or_default();
        let in_query = query.split('&').find_map(|pair| pair.strip_prefix("token="));
        said.or(in_query).is_some_and(|said| same(said.as_bytes(), self.token.as_bytes()))
    }
}

/// Whether two texts are the same, in a time that does not tell where they differ.
fn same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |off, (a, b)| off | (a ^ b)) == 0
}

/// Lets requests of own pages through, and puts the headers on all answers.
pub async fn guard(State(guard): State<Arc<Guard>>, request: Request, next: Next) -> Response {
    let refused = |why: &'static str| (StatusCode::FORBIDDEN, why).into_response();
    let mut response = if !guard.is_own(request.headers()) {
        refused("this server speaks to its own page alone\n")
    } else if !OPEN.contains(&request.uri().path()) && !guard.has_token(&request) {
        refused("the token is wrong: open the address that 'klieg studio' has printed\n")
    } else {
        next.run(request).await
    };
    for (name, value) in HEADERS {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_are_random_or_given_and_long_enough() {
        let (one, other) = (token(None).unwrap(), token(None).unwrap());
        assert!(one != other && one.len() == 32);
        let given = "a-token_of-22-letters0".to_string();
        assert_eq!(token(Some(given.clone())).unwrap(), given);
        for bad in ["", "short", "a-token_of-22-letters\u{e4}", "a token of 22 letters and more"] {
            let fault = token(Some(bad.into())).unwrap_err().to_string();
            assert!(fault.contains(TOKEN_VARIABLE), "{fault}");
        }
    }
}
